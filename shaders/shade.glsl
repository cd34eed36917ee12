// The visible fraction of the sun, brightened by about what totality leaves of scattered light; 1 for 1. What is stored of
// a shadow is relative to it, and smooth where the umbra has its edge.
float shade(float visible) { return (visible + RATIO_SHADE) / (1.0 + RATIO_SHADE); }
