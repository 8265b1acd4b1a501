"""Where the middle of the frame is in image coordinates."""

from orient.values import Row


def frame_centre(row: Row) -> tuple[float, float]:
    """Centre of the frame in mm: the origin, unless the pixel origin was put elsewhere in the image."""
    keys = ("pixel_size_mm", "origin_col_px", "origin_row_px", "image_width_px", "image_height_px")
    values = [row.get(key) for key in keys]
    if row.get("interior_transformation") != "none" or any(not isinstance(value, int | float) for value in values):
        return 0.0, 0.0
    size, col, row_px, width, height = (float(value) for value in values if isinstance(value, int | float))
    x = ((width - 1) / 2 - col) * size * (1 if row.get("x_axis") == "right" else -1)
    y = ((height - 1) / 2 - row_px) * size * (-1 if row.get("y_axis") == "up" else 1)
    return x, y
