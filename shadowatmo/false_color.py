"""Pictures of numbers: widths of lit and shadowed air in false color with a legend, sheets of captioned pictures."""

import math

import numpy as np
from PIL import Image, ImageDraw, ImageFont

LIT = np.array([1.0, 0.62, 0.12])  # linear color of the longest lit path
SHADOWED = np.array([0.10, 0.42, 1.0])  # of the longest shadowed one
PAPER, INK = (16, 18, 22), (232, 232, 228)


def font(size):
    """Return the font of all captions at a size [pixels]."""
    return ImageFont.load_default(size=max(size, 6))


def encode_srgb(linear) -> np.ndarray:
    """Return 8-bit sRGB values of linear ones (IEC 61966-2-1)."""
    linear = np.clip(linear, 0.0, 1.0)
    curved = np.where(linear > 0.0031308, 1.055 * np.maximum(linear, 1e-9) ** (1 / 2.4) - 0.055, 12.92 * linear)
    return np.round(255.0 * curved).astype(np.uint8)


def false_color(lit, shadow, longest) -> np.ndarray:
    """Return the two widths as one linear color: amber for lit air, blue for shadowed air, each in proportion.

    Parameters
    ----------
    lit, shadow : (...) float
        Widths [m].
    longest : float
        Width of the full color [m].
    """
    shares = [np.sqrt(np.clip(np.asarray(w, np.float64) / longest, 0.0, 1.0))[..., None] for w in (lit, shadow)]
    return shares[0] * LIT + shares[1] * SHADOWED


def widths_image(lit, shadow, left=None) -> Image.Image:
    """Return the widths (h, w) [m] of a frame in false color with a legend in metres, `left` pasted over its left."""
    longest = round_up(max(float(np.max(lit)), float(np.max(shadow)), 1.0))
    image = Image.fromarray(encode_srgb(false_color(lit, shadow, longest)))
    if left is not None:
        image.paste(left)
    draw_legend(image, longest)
    return image


def left_half(image) -> Image.Image:
    """Return the left half of a picture."""
    return image.crop((0, 0, image.width // 2, image.height))


def round_up(value) -> float:
    """Return the next number of the row 1, 2, 5, 10 ... that is not below a positive value."""
    decade = 10.0 ** math.floor(math.log10(value))
    return next(step * decade for step in (1.0, 2.0, 5.0, 10.0) if step * decade >= value * (1.0 - 1e-9))


def draw_legend(image, longest) -> None:
    """Draw the two scales into the lower left corner of a picture; pictures too small for words keep their pixels."""
    width, height = image.size
    if width < 200 or height < 120:
        return
    letters = font(height // 44)
    line, bar, left = height // 28, min(width // 3, 380), height // 36
    draw = ImageDraw.Draw(image)
    values = np.linspace(0.0, longest, bar)
    top = height - 6 * line
    rows = (("lit air", values, 0.0 * values), ("air in the planet's shadow", 0.0 * values, values))
    for number, (label, lit, shadow) in enumerate(rows):
        y = top + 2 * number * line
        draw.text((left, y), label, INK, letters)
        colors = encode_srgb(false_color(lit, shadow, longest))
        strip = np.repeat(colors[None], max(line // 2, 1), axis=0)
        image.paste(Image.fromarray(strip), (left, y + int(1.25 * line)))
    y = top + int(4.1 * line)
    for share in (0.0, 0.5, 1.0):
        x = left + share * (bar - 1)
        draw.line((x, y - line // 4, x, y), INK)
        draw.text((x, y), metres(share * longest), INK, letters, anchor="la" if share < 1.0 else "ra")


def metres(value) -> str:
    """Return a length in metres as people read it: 1 250 000 m."""
    return f"{value:,.0f}".replace(",", " ") + " m"


def contact_sheet(pictures, columns=3, width=480) -> Image.Image:
    """Return one sheet of pictures [(image, title, caption)], each `width` pixels wide, with words below them."""
    thumbs = [image.resize((width, max(round(width * image.height / image.width), 1))) for image, _, _ in pictures]
    title_font, caption_font, gap, line = font(17), font(14), 12, 18
    captions = [wrap(caption, caption_font, width) for _, _, caption in pictures]
    cell = max(t.height for t in thumbs) + 28 + line * max(len(c) for c in captions)
    columns = min(columns, len(pictures))
    rows = -(-len(pictures) // columns)
    sheet = Image.new("RGB", (gap + columns * (width + gap), gap + rows * (cell + gap)), PAPER)
    draw = ImageDraw.Draw(sheet)
    for number, (thumb, lines) in enumerate(zip(thumbs, captions, strict=True)):
        x, y = gap + number % columns * (width + gap), gap + number // columns * (cell + gap)
        sheet.paste(thumb, (x, y))
        draw.text((x, y + thumb.height + 4), pictures[number][1], INK, title_font)
        for row, text in enumerate(lines):
            draw.text((x, y + thumb.height + 26 + row * line), text, (170, 172, 176), caption_font)
    return sheet


def wrap(text, letters, width) -> list[str]:
    """Return the text in lines that are at most `width` pixels wide; a word that is longer stands alone."""
    lines = [""]
    for word in text.split():
        longer = f"{lines[-1]} {word}".strip()
        if lines[-1] and letters.getlength(longer) > width:
            lines.append(word)
        else:
            lines[-1] = longer
    return lines
