"""`plan`: what to know first, then elements, correlations, ground accuracy, the worth of each point, the layout."""

import math
from collections.abc import Sequence

import numpy as np

from orient.report.text import console, one_line, print_json, print_table
from orient.solvers.control_effects import Effect
from orient.solvers.functional_iteration import WEAK_CORRELATION, WEAK_RATIO
from orient.solvers.ground_covariance import error_ellipses
from orient.solvers.planning import Plan
from orient.solvers.predicted_ground import ground_by_use
from orient.units import ARC_SECONDS_PER_RADIAN, DEGREES_PER_RADIAN, listed

MICROMETRES = 1000.0
SHOWN_ROWS = 25
SHOWN_PAIRS = 3
SHOWN_PLACES = 5
NEGLIGIBLE = 1e-3
ROUNDING = 1e-9
HARDLY_CHECKED = 0.2
"""Redundancy number of a point's two equations together, 0.1 for each."""
SHIFT_AND_TILT = ({"X_S", "alpha"}, {"Y_S", "omega"}, {"X_S", "phi"})


def show_plan(plan: Plan, layout: str, tilt_deg: float, as_json: bool) -> None:
    """Print the plan; `layout` says in words what was planned."""
    if as_json:
        print_json(_content(plan, layout, tilt_deg))
        return
    out = console()
    for line in [*_head(plan, layout, tilt_deg), *(f"  note: {note}" for note in notes(plan))]:
        out.print(line, soft_wrap=True)
    _print_table("Predicted standard deviations", *_elements(plan))
    _print_table("Strongest correlations", *_correlations(plan))
    for line in advice(plan):
        out.print(line, soft_wrap=True)
    title = f"New ground points, sigma_X / sigma_Y in m over the frame, mean {_short(plan.ground.mean_sigma)} m"
    _print_table(title, *_map(plan))
    out.print(_largest_ellipse(plan), soft_wrap=True)
    _print_table("Without this point: change of the sigmas", *_effects(plan, _most_needed(plan)))
    _print_table("One more control point here (x, y mm): change", *_effects(plan, _most_useful(plan)))
    out.print("\nLayout")
    for line in layout_lines(plan):
        out.print(line, soft_wrap=True)


def notes(plan: Plan) -> list[str]:
    """What is wrong or weak in the plan, in sentences."""
    found = []
    n = len(plan.photo.names)
    if plan.prediction.redundancy == 0:
        found.append("three points leave no redundancy: no error is found, and up to four orientations fit")
    elif needed := [effect.name for effect in plan.without if not effect.is_determined]:
        found.append(f"the orientation is not determined without {_listed(needed)}")
    if plan.prediction.redundancy > 0 and (unchecked := _hardly_checked(plan)):
        found.append(f"hardly checked by the others (an error there would not be seen): {_listed(unchecked)}")
    if plan.prediction.condition_ratio < WEAK_RATIO:
        found.append(f"the geometry of the {n} points is weak: singular values in the ratio 1 to {_weakness(plan)}")
    if blank := int(np.count_nonzero(~plan.ground.met)):
        found.append(f"{blank} of {len(plan.ground.met)} places of the frame look above the horizon")
    return found


def advice(plan: Plan) -> list[str]:
    """What the correlations mean for the use of the elements, with the numbers of this plan."""
    lines = []
    strong = [pair for pair in plan.prediction.correlations() if abs(pair[2]) > WEAK_CORRELATION]
    for first, second, value in strong:
        alike = {first, second} in SHIFT_AND_TILT
        why = "a shift and a tilt of the camera move the image almost alike" if alike else "they are hardly separated"
        lines.append(f"{first} and {second} ({value:.4f}): {why}.")
    if strong:
        lines.append("Relief, an oblique view or a shorter focal length would separate such elements better.")
    sigmas = ground_by_use(plan.photo, plan.prediction, plan.ground)
    full = sigmas.pop("six elements")
    others = "; ".join(f"{use} {_short(sigma)} m (x {_short(sigma / full)})" for use, sigma in sigmas.items())
    lines.append(f"Mean ground sigma from the orientation alone: {_short(full)} m with all six elements and their full")
    lines[-1] += f" covariance matrix; {others}."
    lines.append("Use all six elements together with the full 6 x 6 matrix, never the standard deviations alone.")
    return lines


def layout_lines(plan: Plan) -> list[str]:
    """Is the layout symmetric in the sense of seed 003, and what follows."""
    lines = []
    form = {1: "one D", 2: "Dx and Dy", 0: ""}[plan.symmetry.determinants]
    if plan.symmetry.violated:
        kind = f"The closed form holds with {form}" if form else "No closed form holds"
        lines.append(f"{kind}; violated conditions (xi = x/c, eta = y/c):")
        lines += [f"  {each.name} = {each.value:.6g}, should be 0" for each in plan.symmetry.violated]
    else:
        lines.append("Symmetric: every condition of the closed form (8)-(10) of seed 003 is met.")
    closed = plan.closed
    if closed is None:
        return [*lines, "The closed forms are for a vertical photo, flat ground and errorless control; not this plan."]
    if closed.sigma is not None:
        apart = float(np.max(np.abs(closed.sigma / plan.prediction.sigma - 1)))
        lines.append(f"The closed form with {form} gives the same sigmas, within {max(apart, ROUNDING):.0e} of them.")
    if plan.symmetry.violated:
        lines.append(f"With one D it would be wrong by up to {100 * closed.largest_error:.3g} % of a sigma.")
    lines.append(
        f"At x = y = c = {closed.c_mm:g} mm the orientation adds {closed.corner:.4f} sigma of a reading, whatever the "
        f"focal length: the terms with f/c are as large as {_short(closed.focal_terms)} sigma^2 and cancel to 0."
    )
    return lines


def _head(plan: Plan, layout: str, tilt_deg: float) -> list[str]:
    photo, sigmas = plan.photo, plan.photo.sigmas
    view = f"{tilt_deg:g} degrees off vertical" if tilt_deg else "vertical"
    known = f"{sigmas.control_m:g} m in plan, {sigmas.height_m:g} m in height"
    errorless = sigmas.control_m == 0 and sigmas.height_m == 0
    n = len(photo.names)
    return [
        f"f {photo.f_mm:g} mm, {photo.station[2]:,.10g} m above the ground, {view}; layout {one_line(layout)}",
        f"{n} points, {2 * n} equations, redundancy {plan.prediction.redundancy}; sigma of a reading "
        f"{MICROMETRES * sigmas.image_mm:g} um, control {'errorless' if errorless else known}",
        "X runs along x, Y along y of the vertical photo, Z up; x right, y up from the principal point",
    ]


def _elements(plan: Plan) -> tuple[list[str], list[list[str]]]:
    cells = []
    for i, (name, sigma) in enumerate(zip(plan.prediction.names, plan.prediction.sigma, strict=True)):
        in_degrees, seconds = sigma * DEGREES_PER_RADIAN, sigma * ARC_SECONDS_PER_RADIAN
        cells.append(
            [f"{name} m", _short(sigma), ""] if i < 3 else [f"{name} deg", _short(in_degrees), f'{seconds:.3g}"']
        )
    return ["element", "sigma", ""], cells


def _correlations(plan: Plan) -> tuple[list[str], list[list[str]]]:
    pairs = [pair for pair in plan.prediction.correlations()[:SHOWN_PAIRS] if abs(pair[2]) > NEGLIGIBLE]
    return ["elements", "correlation"], [[f"{first}, {second}", f"{value:.5f}"] for first, second, value in pairs]


def _map(plan: Plan) -> tuple[list[str], list[list[str]]]:
    """The frame as it is seen: top row first, a dash for the sky."""
    image, total = plan.ground.image, plan.ground.covariance.total
    columns = len(np.unique(image[:, 0]))
    cells = []
    for at in np.arange(len(image)).reshape(-1, columns):
        sigmas = [
            f"{_short(math.sqrt(total[i, 0, 0]))} / {_short(math.sqrt(total[i, 1, 1]))}" if plan.ground.met[i] else "-"
            for i in at
        ]
        cells.append([f"{image[at[0], 1]:g}", *sigmas])
    return ["y \\ x mm", *(f"{x:g}" for x in image[:columns, 0])], cells


def _largest_ellipse(plan: Plan) -> str:
    ellipses = _ellipses(plan)
    i = max(ellipses, key=lambda i: _rounded(ellipses[i][0]))
    (x, y), (a, b, azimuth) = plan.ground.image[i], ellipses[i]
    return (
        f"Largest error ellipse: {_short(a)} x {_short(b)} m at x {x:g}, y {y:g} mm, its long axis "
        f"{azimuth:.0f} degrees from X towards Y."
    )


def _ellipses(plan: Plan) -> dict[int, list[float]]:
    """Semi-axes [m] and azimuth [deg] of the points that are met."""
    met = np.flatnonzero(plan.ground.met)
    found = error_ellipses(plan.ground.covariance.total[met, :2, :2]) * [1.0, 1.0, DEGREES_PER_RADIAN]
    return dict(zip(met.tolist(), found.tolist(), strict=True))


def _most_needed(plan: Plan) -> list[Effect]:
    return sorted(plan.without, key=lambda effect: -_rounded(effect.mean_sigma))[:SHOWN_ROWS]


def _most_useful(plan: Plan) -> list[Effect]:
    return sorted(plan.one_more, key=lambda effect: _rounded(effect.mean_sigma))[:SHOWN_PLACES]


def _rounded(value: float) -> float:
    """Points that are equal by symmetry keep their order."""
    return float(f"{value:.9g}")


def _effects(plan: Plan, effects: Sequence[Effect]) -> tuple[list[str], list[list[str]]]:
    headers = ["point", *plan.prediction.names, "ground", "ground m"]
    cells = []
    for effect in effects:
        changes = [*(effect.sigma / plan.prediction.sigma), effect.mean_sigma / plan.ground.mean_sigma]
        values = [_percent(ratio) for ratio in changes] if effect.is_determined else ["not determined"] + ["-"] * 6
        cells.append([one_line(effect.name), *values, _short(effect.mean_sigma) if effect.is_determined else "-"])
    return headers, cells


def _hardly_checked(plan: Plan) -> list[str]:
    numbers = plan.prediction.redundancy_numbers
    return [name for name, r in zip(plan.photo.names, numbers, strict=True) if r < HARDLY_CHECKED]


def _listed(names: Sequence[str]) -> str:
    return one_line(listed(names, SHOWN_PLACES))


def _weakness(plan: Plan) -> str:
    return f"{1 / plan.prediction.condition_ratio:.3g}"


def _percent(ratio: float) -> str:
    change = round(100 * (ratio - 1), 1) + 0.0
    if change == 0:
        return "0.0 %"
    return f"{change:+.1f} %" if abs(change) < 1000 else f"x {ratio:.3g}"


def _short(value: float) -> str:
    """Four significant digits, without an exponent for what people measure."""
    return f"{value:.4g}" if abs(value) < 1e4 else f"{value:,.0f}"


def _print_table(title: str, headers: list[str], rows: list[list[str]]) -> None:
    if rows:
        out = console()
        out.print(f"\n{title}")
        print_table(headers, rows, [i > 0 for i in range(len(headers))])


def _content(plan: Plan, layout: str, tilt_deg: float) -> dict[str, object]:
    photo, prediction = plan.photo, plan.prediction
    return {
        "layout": layout,
        "f_mm": photo.f_mm,
        "height_m": float(photo.station[2]),
        "tilt_deg": tilt_deg,
        "sigma_image_mm": photo.sigmas.image_mm,
        "sigma_control_m": photo.sigmas.control_m,
        "sigma_control_height_m": photo.sigmas.height_m,
        "redundancy": prediction.redundancy,
        "condition_ratio": prediction.condition_ratio,
        "notes": notes(plan),
        "elements": [
            {"element": name, "unit": "m" if i < 3 else "rad", "sigma": float(prediction.sigma[i])}
            for i, name in enumerate(prediction.names)
        ],
        "covariance": prediction.covariance.tolist(),
        "correlations": [{"elements": [a, b], "value": value} for a, b, value in prediction.correlations()],
        "advice": advice(plan),
        "ground_mean_sigma_m": plan.ground.mean_sigma,
        "ground_sigma_by_use_m": ground_by_use(photo, prediction, plan.ground),
        "ground": _places(plan),
        "points": _points(plan),
        "without": [_effect(plan, effect) for effect in plan.without],
        "one_more": [_effect(plan, effect) for effect in plan.one_more],
        "closed_form": _closed(plan),
    }


def _points(plan: Plan) -> list[dict[str, object]]:
    photo, numbers = plan.photo, plan.prediction.redundancy_numbers.tolist()
    return [
        {
            "point": name,
            **dict(zip(("x_mm", "y_mm"), photo.image[i].tolist(), strict=True)),
            **dict(zip(("X_m", "Y_m", "Z_m"), photo.ground[i].tolist(), strict=True)),
            "redundancy_number": numbers[i],
        }
        for i, name in enumerate(photo.names)
    ]


def _places(plan: Plan) -> list[dict[str, object]]:
    ground, parts = plan.ground, plan.ground.covariance
    content: list[dict[str, object]] = []
    for i, (a, b, azimuth) in _ellipses(plan).items():
        total = parts.total[i]
        content.append(
            {
                **dict(zip(("x_mm", "y_mm"), ground.image[i].tolist(), strict=True)),
                **dict(zip(("X_m", "Y_m"), ground.ground[i, :2].tolist(), strict=True)),
                "sigma_X_m": math.sqrt(total[0, 0]),
                "sigma_Y_m": math.sqrt(total[1, 1]),
                "ellipse_a_m": a,
                "ellipse_b_m": b,
                "ellipse_azimuth_deg": azimuth,
                "orientation_m2": parts.orientation[i, :2, :2].tolist(),
                "reading_m2": parts.reading[i, :2, :2].tolist(),
                "height_m2": parts.height[i, :2, :2].tolist(),
            }
        )
    return content


def _effect(plan: Plan, effect: Effect) -> dict[str, object]:
    place = {"point": effect.name, "x_mm": effect.x_mm, "y_mm": effect.y_mm}
    if not effect.is_determined:
        return {**place, "is_determined": False, "sigma": None, "ground_mean_sigma_m": None}
    sigma = dict(zip(plan.prediction.names, effect.sigma.tolist(), strict=True))
    return {**place, "is_determined": True, "sigma": sigma, "ground_mean_sigma_m": effect.mean_sigma}


def _closed(plan: Plan) -> dict[str, object]:
    closed = plan.closed
    verdict: dict[str, object] = {
        "determinants": plan.symmetry.determinants,
        "violated": [{"condition": each.name, "value": each.value} for each in plan.symmetry.violated],
        "applies": closed is not None,
    }
    if closed is not None:
        verdict |= {
            "c_mm": closed.c_mm,
            "sigma": None if closed.sigma is None else closed.sigma.tolist(),
            "largest_error_of_one_D": closed.largest_error,
            "corner_in_sigma": closed.corner,
            "largest_term_of_f_c": closed.focal_terms,
        }
    return verdict
