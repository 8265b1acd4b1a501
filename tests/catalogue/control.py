"""C: control points, as far as a list or a setting shows it; weak geometry is in tests/cli/test_bad_control.py."""

from tests.catalogue.case import NEW, PROJECT, Case, Place, refused
from tests.cli.made_photo import GROUND, MadePhoto

FLAT = GROUND * [1, 1, 0] + [0, 0, 150]
GEOCENTRIC = '[control]\nkind = "geocentric"\n'


def vertical_over_flat_ground(place: Place) -> None:
    MadePhoto(seen=FLAT, angles=(0.0, 0.0, 0.0)).write(place.folder)
    assert place.say(NEW).code == 0
    assert place.say(("run", PROJECT)).code == 0


CASES: dict[str, Case] = {
    "C4": Case(
        words=("resection", PROJECT, "--estimate", "f", "--free-camera"),
        says=["SINGULAR: f and Z_S cannot be separated (correlation 1.000)"],
        before=vertical_over_flat_ground,
        changes=True,
    ),
    "C10 half a position": refused(
        "control.csv:2: half a plan position: give both plan coordinates, or none",
        control="point,B_deg,L_deg,H_m\nA,1,,3\n",
    ),
    "C10 geocentric": refused(
        "control.csv:2: a geocentric point needs X_m, Y_m and Z_m",
        control="point,X_m,Y_m,Z_m\nA,1,2,\n",
        control_toml=GEOCENTRIC,
    ),
    "C14 height missing": refused(
        "control.csv: no control points. All points have the role check",
        control="point,role,B_deg,L_deg,H_m\nA,check,1,2,\n",
    ),
    "C20 half of the sigmas": refused(
        'control.csv:2: column "sigma_E_m": value is missing. '
        "Leave all of them empty for a point that is taken as known",
        control="point,B_deg,L_deg,H_m,sigma_N_m,sigma_E_m,sigma_H_m\nA,1,2,3,1,,1\n",
    ),
}
