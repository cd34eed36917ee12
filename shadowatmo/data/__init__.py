"""Earth's color and heights, the images of the package; README.md beside this file describes them."""
