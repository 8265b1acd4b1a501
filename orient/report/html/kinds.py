"""Stable words of the file (codes of findings, stages, verdicts, roles) in the reader's language."""

from orient.report.language import mark, tr

FINDINGS = {
    "ambiguous": mark("Several orientations fit equally well"),
    "ambiguous_model": mark("Several positions of the model fit equally well"),
    "bad_cross": mark("A cross of the map does not fit"),
    "bad_mark": mark("A fiducial mark does not fit"),
    "ballpark": mark("The datum shift is not known"),
    "calibration": mark("Calibration by steps"),
    "camera_contradicted": mark("The control contradicts the camera's data"),
    "camera_not_significant": mark("Estimated elements of the camera are not significant"),
    "camera_weak": mark("An element of the camera is hardly determined"),
    "correlation": mark("Strong correlations"),
    "curvature": mark("Correction for earth curvature"),
    "cycle_outlier": mark("A reading deviates from the others of its point"),
    "cycle_sigma": mark("Precision from repeated readings"),
    "degree_choices": mark("The degree of the map's polynomial is open to choice"),
    "excluded": mark("A point was left out"),
    "exchange": mark("Two coordinates seem to be exchanged"),
    "far_point": mark("A point lies far from all others"),
    "fiducial_unmatched": mark("A fiducial mark has no counterpart"),
    "fiducials_unused": mark("Fiducial marks were read and not used"),
    "given_twice": mark("A point is given twice"),
    "global_test": mark("The residuals do not fit the standard deviations given"),
    "hardly_checked": mark("Some readings are hardly checked by the others"),
    "known_contradicted": mark("The control contradicts what was known of the camera"),
    "lens_folds": mark("The distortion is not unique at the edge of the frame"),
    "later_failure": mark("A later version failed"),
    "level_ray": mark("A ray hardly meets the ground"),
    "masked": mark("Gross errors may hide one another"),
    "mirror": mark("The opposite side of the control plane fits too"),
    "mirrored": mark("The axes are mirrored"),
    "no_control": mark("Measured points without control"),
    "no_coordinates": mark("A control point has no coordinates"),
    "no_map": mark("There is no map of the accuracy"),
    "no_redundancy": mark("Nothing checks the result"),
    "not_checked": mark("Some readings are not checked at all"),
    "not_in_model": mark("Control points are not in the model"),
    "not_measured": mark("Control points were not measured"),
    "not_removable": mark("A suspicious point cannot be left out"),
    "not_separable": mark("Two suspicious points cannot be told apart"),
    "odd_point": mark("One point does not fit the others"),
    "partial_point": mark("A point is only partly known"),
    "partly_given": mark("A point is only partly known"),
    "passed_through": mark("Local coordinates were taken as they are"),
    "poor_fit": mark("The model does not fit the control"),
    "proposed": mark("It is proposed to leave a point out"),
    "radius_polynomial": mark("Radius of curvature by the polynomial"),
    "refused": mark("The computation was refused"),
    "robust": mark("Points that do not agree with the others were found"),
    "singular": mark("The control does not determine the orientation"),
    "small_angles": mark("Small-angle formulas"),
    "small_sigma0": mark("The standard deviations given are too large"),
    "suspect": mark("A gross error is suspected"),
    "taken_back": mark("A point that was left out was taken back"),
    "upside_down": mark("The model hangs upside down"),
    "weak_geometry": mark("The geometry is weak"),
    "zones_differ": mark("The zones differ at common points"),
}
STAGES = {
    "photo": mark("photo and camera"),
    "readings": mark("readings on the photo"),
    "sheet": mark("map sheets"),
    "control": mark("control points"),
    "model": mark("model points"),
    "refine": mark("image coordinates"),
    "digitize": mark("map points by the sheets' polynomials"),
    "bl": mark("latitude, longitude, height"),
    "topocentric": mark("topocentric coordinates"),
    "resection": mark("exterior orientation"),
    "covariance": mark("accuracy of ground points"),
    "absolute": mark("absolute orientation of the model"),
    "image": mark("image file"),
    "verify": mark("verification"),
    "seal": mark("seal"),
}
VERDICTS = {
    "good": mark("Oriented; no problem was found."),
    "doubtful": mark("Oriented, but with problems: read them before you use a number."),
    "stale": mark("The result is out of date: an input has changed since. Run the computation again."),
    "failed": mark("No valid result: a computation failed."),
    "incomplete": mark("Not oriented yet."),
}
WORDS = {
    "control": mark("control"),
    "check": mark("check"),
    "excluded": mark("excluded"),
    "rejected": mark("rejected"),
    "fit": mark("fit"),
    "free": mark("new point"),
    "good": mark("good"),
    "suspect": mark("suspect"),
    "hardly checked": mark("hardly checked"),
    "not checked": mark("not checked"),
    "accepted": mark("accepted"),
    "too large": mark("too large"),
    "too small": mark("too small"),
    "no redundancy": mark("no redundancy"),
    "proposed": mark("proposed"),
    "taken back": mark("taken back"),
    "not separable": mark("not separable"),
    "not removable": mark("not removable"),
    "snooping": mark("by the test"),
    "hand": mark("by hand"),
    "robust": mark("by agreement of the others"),
    "a posteriori": mark("a posteriori"),
    "a priori": mark("a priori"),
    "succeeded": mark("succeeded"),
    "failed": mark("failed"),
    "identical": mark("identical in all bits"),
    "agrees": mark("agrees"),
    "differs": mark("differs"),
    "taken": mark("taken"),
    "not significant": mark("not significant"),
    "not solved": mark("not solved"),
    "less significant": mark("less significant"),
    "plan": mark("plan"),
    "height": mark("height"),
    "space": mark("from space"),
    "aerial": mark("from the air"),
    "terrestrial": mark("from the ground"),
    "interior orientation": mark("interior orientation"),
}
FRAMES = {
    "topocentric": mark("T′: X grid north, Y grid east, Z up"),
    "local_right": mark("local, right-handed"),
    "local_left": mark("local, left-handed"),
}


def finding(code: str) -> str:
    """A finding's kind; a code of a later version stays as it is."""
    return tr(FINDINGS[code]) if code in FINDINGS else code


def stage(name: str) -> str:
    return tr(STAGES[name]) if name in STAGES else name


def word(value: object) -> str:
    text = str(value)
    return tr(WORDS[text]) if text in WORDS else text


def frame(kind: object) -> str:
    return tr(FRAMES[str(kind)]) if str(kind) in FRAMES else str(kind)
