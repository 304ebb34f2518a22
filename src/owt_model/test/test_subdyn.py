"""SubDyn decks: variants of the format, refusals by name, and garbage that is never a traceback."""

from __future__ import annotations

from pathlib import Path

import pytest

from owt_model.errors import InputError
from owt_model.structure import load_structure
from owt_model.subdyn import parse_subdyn

DECK = (Path(__file__).parents[3] / "test" / "data" / "structure" / "tripod.dat").read_text(encoding="utf-8")
QR0 = """---- INITIAL RIGID-BODY POSITION ----
PtfmSurge PtfmSway PtfmHeave PtfmRoll PtfmPitch PtfmYaw
(m) (m) (m) (deg) (deg) (deg)
0 0 0 0 0 0
"""
PARTS = {
    "QR0": "",
    "INTERFACE": "   4  1 1 1 1 1 1\n   7  1 1 1 1 1 1",
    "MEMBERS": "   1 1 4 1 1 1c 0\n   2 2 4 1 3 1c 0\n   3 3 4 1 1 1c 0\n   5 4 7 2 2 1c 0",
    "MASS": "   4  5.0e3  1.0 2.0 3.0 0.1 0.2 0.3 0.5 0.6 0.7",
}


def deck(**parts):
    text = DECK
    for name, value in (PARTS | parts).items():
        text = text.replace(f"@{name}@", value)
    return text


def parse(text):
    return parse_subdyn(text, source="deck.dat")


def test_everything_arrives():
    s = parse(deck())
    assert s.beam == "timoshenko"
    assert s.rotary_inertia
    assert s.elements_per_member == 2
    assert s.joints["J7"] == (2.0, 1.0, 12.0)
    assert s.members["M5"].joints == ("J4", "J7")
    assert s.members["M2"].section == "P1"  # both ends have the same tube under two numbers
    assert s.sections["P1"].youngs_modulus_pa == 2.1e11
    assert s.sections["P2"].thickness_m == 0.02
    assert s.supports["J3"] == (True, True, True, False, False, False)
    assert s.mudline_z_m == -21.0
    assert s.interface.joints == ("J4", "J7")
    assert s.interface.reference_m == (1.0, 0.5, 12.0)  # centroid of the interface, level of the highest
    mass = s.point_masses["J4"]
    assert (mass.mass_kg, mass.inertia_kg_m2) == (5e3, (1.0, 2.0, 3.0, 0.1, 0.2, 0.3))
    assert mass.offset_m == (0.5, 0.6, 0.7)
    assert (s.tower, s.marine_growth, s.flooding, s.added_mass) == (None,) * 4


@pytest.mark.parametrize(
    "variant",
    [
        {"QR0": QR0},
        {"INTERFACE": "4\n7"},
        {"INTERFACE": "4 1\n7 1"},
        {"INTERFACE": "4 1 1 1 1 1 1 1\n7 1 1 1 1 1 1 1"},
        {"MEMBERS": PARTS["MEMBERS"].replace("1c 0", "")},
        {"MEMBERS": PARTS["MEMBERS"].replace("1c 0", "1")},
        {"MEMBERS": PARTS["MEMBERS"].replace("1c 0", "1 -1")},
    ],
)
def test_variants_of_the_format_mean_the_same(variant):
    assert parse(deck(**variant)).content_hash == parse(deck()).content_hash


def test_old_files_have_a_cosine_matrix_where_the_member_type_is_now():
    old = deck(MEMBERS=PARTS["MEMBERS"].replace("1c 0", "3")).replace(
        "MPropSetID2 MType COSMID", "MPropSetID2 COSMID"
    )
    assert parse(old).content_hash == parse(deck()).content_hash
    with pytest.raises(InputError, match="rigid links"):
        parse(deck(MEMBERS=PARTS["MEMBERS"].replace("1c 0", "3")))


def test_tapered_members():
    s = parse(deck(MEMBERS=PARTS["MEMBERS"].replace("5 4 7 2 2", "5 4 7 2 1")))
    assert (s.members["M5"].section, s.members["M5"].section_last) == ("P2", "P1")
    text = deck(MEMBERS=PARTS["MEMBERS"].replace("5 4 7 2 2", "5 4 7 2 1"))
    other = text.replace("2.1e11    8.0769e10   7850.0   0.8", "2.1e11    8.1e10   7850.0   0.8")
    with pytest.raises(InputError, match=r"section_last.*shear_modulus"):
        parse(other)


RIGID = """----------------------- RIGID LINK PROPERTIES ----------------------------
             1   NRigidPropSets - Number of rigid link properties
PropSetID   MatDens
  (-)       (kg/m)
   9        @DENSITY@
------------------------ JOINT ADDITIONAL"""


def with_link(density):
    text = deck(MEMBERS=PARTS["MEMBERS"].replace("5 4 7 2 2 1c 0", "5 4 7 9 9 3 -1"))
    return text.replace("------------------------ JOINT ADDITIONAL", RIGID.replace("@DENSITY@", density))


def test_rigid_links_and_their_mass():
    """A rod of 120 kg/m over (2, 1, 2) m joins the body at its first joint: total, centre and inertia."""
    light = parse(with_link("0"))
    assert light.rigid_links["M5"].joints == ("J4", "J7")
    assert "M5" not in light.members
    assert light.point_masses["J4"].mass_kg == 5e3
    body, rod = parse(with_link("120")).point_masses["J4"], 120.0 * 3.0
    assert body.mass_kg == pytest.approx(5e3 + rod, rel=1e-14)
    x, y = (5e3 * 0.5 + rod * 1.0) / body.mass_kg, (5e3 * 0.6 + rod * 0.5) / body.mass_kg
    assert body.offset_m[:2] == pytest.approx((x, y), rel=1e-14)
    # about the joint: Steiner of the body, and m L^2/3 of the rod for its end
    z = body.offset_m[2]
    about_joint = body.inertia_kg_m2[0] + body.mass_kg * (y**2 + z**2)
    assert about_joint == pytest.approx(1.0 + 5e3 * (0.6**2 + 0.7**2) + rod * (1.0 + 4.0) / 3.0, rel=1e-12)
    for wrong in ("-1", "dense"):
        with pytest.raises(InputError, match="MatDens"):
            parse(with_link(wrong))


SPRINGS = """----------------------- SPRING ELEMENT PROPERTIES ------------------------
 1 NSpringPropSets
PropSetID k11 k12
(-) (N/m)
6 1e9 0 0 0 2e7 0  1e9 0 0 0 0  1e10 0 0 0  1e10 0 0  1e10 0  1e10
---------------------- MEMBER COSINE MATRICES COSM(i,j) ------------------
 2 NCOSMs
COSMID COSM11
(-) (-)
1 1 0 0 0 -1 0 0 0 -1
2 0 1 0 -1 0 0 0 0 1
------------------------ JOINT ADDITIONAL"""


def with_spring(cosine):
    """The deck with its joint 7 on joint 8, on which member 5 ends."""
    text = deck(MEMBERS=PARTS["MEMBERS"].replace("5 4 7", "5 4 8") + f"\n 6 8 7 6 6 5 {cosine}")
    text = text.replace("4   NMembers", "5   NMembers").replace("5   NJoints", "6   NJoints")
    text = text.replace("   7\t 2.0d0", "   8  2.0 1.0 12.0 1 0 0 0 0\n   7\t 2.0d0")
    return text.replace("------------------------ JOINT ADDITIONAL", SPRINGS)


def test_spring_members():
    """Upper triangle row by row; a cosine matrix may turn axes round."""
    s = parse(with_spring(-1))
    spring = s.joint_springs["M6"]
    assert spring.joints == ("J8", "J7")
    assert (spring.matrix[0][4], spring.matrix[4][0], spring.matrix[2][2]) == (2e7, 2e7, 1e10)
    assert parse(with_spring(1)).joint_springs["M6"].matrix[0][4] == -2e7
    for cosine, message in ((2, "COSMID.*turns"), (3, "COSMID.*no cosine matrix")):
        with pytest.raises(InputError, match=message):
            parse(with_spring(cosine))
    with pytest.raises(InputError, match="no spring property"):
        parse(with_spring(-1).replace("8 7 6 6 5", "8 7 5 5 5"))
    with pytest.raises(InputError, match="not on the place"):
        parse(with_spring(-1).replace("8 7 6 6 5", "8 4 6 6 5"))


def test_revolute_and_spherical_joints():
    """All members but the first are released at such a joint."""
    text = deck().replace("10.0      1  0.0  0.0  0.0  0.0", "10.0      4  0.0  0.0  0.0  0.0")
    s = parse(text)
    assert s.members["M1"].releases == (None, None)
    assert s.members["M2"].release_last.about == "xyz"
    assert s.members["M5"].release_first.about == "xyz"
    with pytest.raises(InputError, match=r"joint 4.*Divide"):
        parse(text.replace("4  0.0  0.0  0.0  0.0", "4  0.0  0.0  0.0  5e6"))
    hinge = deck().replace("7\t 2.0d0\t 1.0\t 12.0\t 1\t 0.0 0.0 0.0 0.0", "7 2.0 1.0 12.0 3 0.0 1.0 0.0 5e6")
    more = PARTS["MEMBERS"] + "\n   6 1 7 1 1 1c 0"
    s = parse(hinge.replace("4   NMembers", "5   NMembers").replace(PARTS["MEMBERS"], more))
    assert s.members["M6"].release_last.hinge == (0.0, 1.0, 0.0)
    assert s.members["M6"].release_last.stiffness_nm_rad == 5e6


SOIL = """! soil of our own
1.0D9   Kxx   - lateral
1.0e9   Kyy
4.0e9   Kzz
-2.0e9  Kxty
2.0e9   Kytx
3.0e10  Ktxtx
3.0e10  Ktyty
1.0e10  Ktztz
2.0e3   Mxx
2.0e3   Myy
2.0e3   Mzz
5.0e2   Mtxtx
"""


def test_soil_springs(tmp_path):
    """A reaction joint on a soil file: symmetric, by name; free directions only are what it supports."""
    path = tmp_path / "tripod.dat"
    old, new = (
        '   1       1        1        1        1        1        1       ""',
        '   1  0 0 1 0 0 0  "pile.txt"',
    )
    assert old in deck()
    path.write_text(deck().replace(old, new), encoding="utf-8")
    with pytest.raises(InputError, match=r"SSIfile.*cannot be read"):
        load_structure(str(path))
    (tmp_path / "pile.txt").write_text(SOIL, encoding="utf-8")
    s = load_structure(str(path))
    matrix = s.support_springs["J1"].matrix
    assert matrix[0][4] == matrix[4][0] == -2e9
    assert matrix[1][3] == 2e9
    assert matrix[2][2] == 4e9
    assert s.supports["J1"] == (False, False, True, False, False, False)
    assert s.point_masses["J1"].mass_kg == 2e3
    assert s.point_masses["J1"].inertia_kg_m2 == (5e2, 0.0, 0.0, 0.0, 0.0, 0.0)
    for line, message in (
        ("5.0 Mxx", "one mass"),
        ("1.0 Mxty", "couplings"),
        ("-1 Mtztz", "at least 0"),
        ("x Kxx", "Kxx"),
        ("-1e9 Ktztz", "must not be negative"),
    ):
        (tmp_path / "pile.txt").write_text(f"{SOIL}{line}\n", encoding="utf-8")
        with pytest.raises(InputError, match=message):
            load_structure(str(path))
    (tmp_path / "pile.txt").write_text("nothing here\n", encoding="utf-8")
    with pytest.raises(InputError, match="no stiffness"):
        load_structure(str(path))


def test_soil_mass_joins_the_body_at_its_joint(tmp_path):
    path = tmp_path / "tripod.dat"
    text = deck(MASS="   1  1.0e3").replace('1        1        1       ""\n   2', '0 0 0 "pile.txt"\n   2')
    path.write_text(text.replace("1.0e3", "1.0e3 0 0 0 0 0 0 0 0 3.0"), encoding="utf-8")
    (tmp_path / "pile.txt").write_text(SOIL, encoding="utf-8")
    body = load_structure(str(path)).point_masses["J1"]
    assert body.mass_kg == 3e3
    assert body.offset_m == (0.0, 0.0, 1.0)
    assert body.inertia_kg_m2[1] == pytest.approx(1e3 * 2.0**2 + 2e3 * 1.0**2, rel=1e-14)


def test_reaction_joints_as_subdyn_reads_them():
    """The joint alone is fixed; a soil file counts only where a direction is free; all free is no support."""
    row = '   1       1        1        1        1        1        1       ""'
    fixed = parse(deck())
    assert parse(deck().replace(row, "   1")).content_hash == fixed.content_hash
    assert parse(deck().replace(row, '   1  1 1 1 1 1 1 "no.txt"')).content_hash == fixed.content_hash
    s = parse(deck().replace(row, "   1  0 0 0 0 0 0"))
    assert set(s.supports) == {"J2", "J3"}
    assert not s.free
    for short in ("   1  1 1", "   1  0 0 0 0 0"):
        with pytest.raises(InputError, match="Rct"):
            parse(deck().replace(row, short))


def test_oldest_tables_have_no_line_of_units():
    """Such files come with five columns of members; the type of member may be named all the same."""
    text = deck(MEMBERS=PARTS["MEMBERS"].replace("1c 0", "")).replace("MType COSMID", "COSMID")
    units = "  (-)       (-)       (-)        (-)         (-)      (-)    (-)\n"
    assert units in text
    assert parse(text.replace(units, "")).content_hash == parse(deck()).content_hash
    typed = deck(MEMBERS=PARTS["MEMBERS"].replace("5 4 7 2 2 1c 0", "5 4 7 2 2 2 0"))
    with pytest.raises(InputError, match=r"MType.*cable"):
        parse(typed.replace(units, ""))


def test_element_model_and_subdivision_without_their_keywords():
    text = deck().replace("3   FEMMod      - ", "3 - ").replace("2   NDiv        - ", "2 - ")
    assert "FEMMod" not in text
    assert parse(text).content_hash == parse(deck()).content_hash
    assert parse(text.replace("3 - FEM", "1 - FEM")).beam == "euler-bernoulli"
    with pytest.raises(InputError, match="FEMMod"):
        parse(text.replace("FEA and", "Parameters and"))


def test_element_size_of_single_members_is_said():
    rows = PARTS["MEMBERS"].replace("5 4 7 2 2 1c 0", "5 4 7 2 2 1c 0 1.25")
    newer = deck(MEMBERS=rows).replace("MType COSMID", "MType MSpin/COSMID MDivSize")
    assert any("MDivSize" in note for note in parse(newer).notes)
    without = deck().replace("MType COSMID", "MType MSpin/COSMID MDivSize")
    assert not any("MDivSize" in note for note in parse(without).notes)


def test_number_of_the_transition_piece_before_the_flags():
    text = deck(INTERFACE="4 2 1 1 1 1 1 1\n7 2 1 1 1 1 1 1")
    newer = text.replace("IJointID ItfTDXss", "IJointID TPID ItfTDXss")
    assert parse(newer).content_hash == parse(deck()).content_hash
    with pytest.raises(InputError, match="ItfTDXss"):
        parse(text)
    reference = newer.replace("4 2 1 1 1 1 1 1", "4 0 1 1 1 1 1 1")
    assert parse(reference).interface.joints == ("J7",)  # number 0: what a floating structure's motion is of
    with pytest.raises(InputError, match="TPID"):
        parse(newer.replace("4 2 1 1 1 1 1 1", "4 1 1 1 1 1 1 1"))


def test_sections_may_be_missing_where_no_beam_asks_for_them():
    """What is refused then is the member, by its type."""
    text = deck(MEMBERS=PARTS["MEMBERS"].replace("1c 0", "1r 0")).replace("3   NPropSets", "0   NPropSets")
    with pytest.raises(InputError, match="rectangular"):
        parse(text)


def test_what_is_left_out_is_said():
    notes = parse(deck()).notes
    assert any("transition piece" in note for note in notes)
    assert any("JDampings" in note for note in notes)
    assert not any("GuyanDampMod" in note for note in notes)
    assert any(
        "GuyanDampMod" in note for note in parse(deck().replace("0   GuyanDampMod", "2   GuyanDampMod")).notes
    )


def test_no_reaction_joints():
    """Such a deck is of use with its interface held only, and says so."""
    text = deck().replace("3   NReact", "0   NReact")
    s = parse(text)
    assert s.free
    assert not parse(deck()).free
    assert any("NReact" in note for note in s.notes)
    assert s.mudline_z_m == -21.0


def test_solid_bars():
    assert parse(deck().replace("0.8   2.0E-2", "0.8   0")).sections["P2"].thickness_m == 0.4


def test_short_mass_rows_and_other_element():
    s = parse(deck(MASS="4 1d3 1 2 3").replace("3   FEMMod", "1   FEMMod"))
    assert s.beam == "euler-bernoulli"
    assert s.point_masses["J4"].inertia_kg_m2 == (1.0, 2.0, 3.0, 0.0, 0.0, 0.0)


def test_numbers_separated_by_commas_and_crlf():
    text = deck(INTERFACE="4, 1,1,1,1,1,1\n7, 1,1,1,1,1,1").replace("\n", "\r\n")
    assert parse(text).content_hash == parse(deck()).content_hash


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("3   FEMMod", "2   FEMMod", "FEMMod"),
        ("2   NDiv", "0   NDiv", "NDiv"),
        ("2   NDiv", "2.5   NDiv", "NDiv"),
        ("1     8.0      0.0    -20.0      1", "1     8.0      0.0    -20.0      2", "JointType"),
        ("1     8.0      0.0    -20.0      1", "1     8.0      0.0    -20.0      3", "JointDirX"),
        ("-20.0      1  0.0  0.0  0.0  0.0", "-20.0      4  0.0  0.0  0.0  -1.0", "JointStiff"),
        ("1     8.0      0.0", "1     8.0      oops", "JointYss"),
        ("1     8.0      0.0", "1     8.0      nan", "JointYss"),
        ("1     8.0      0.0", "1     1e999      0.0", "JointXss"),
        ('1        0        0        0       ""', '1  0 0 0  "soil.txt"', "SSIfile"),
        ("   4  1 1 1 1 1 1", "   4  1 1 1 0 0 0", "ItfTDXss"),
        ("   4  1 1 1 1 1 1\n   7  1 1 1 1 1 1", "   4  1\n   7  2", "TPID"),
        ("   4  1 1 1 1 1 1", "   9  1 1 1 1 1 1", "IJointID"),
        ("5 4 7 2 2 1c 0", "5 4 7 2 2 1r 0", "MType"),
        ("5 4 7 2 2 1c 0", "5 4 7 2 2 2 0", "MType.*cable"),
        ("5 4 7 2 2 1c 0", "5 4 7 2 2 3", "MPropSetID1.*rigid link"),
        ("5 4 7 2 2 1c 0", "5 4 7 9 9 1c 0", "MPropSetID1"),
        ("5 4 7 2 2 1c 0", "5 4 8 2 2 1c 0", "MJointID2"),
        ("5 4 7 2 2 1c 0", "3 4 7 2 2 1c 0", "MemberID.*twice"),
        ("   4  5.0e3", "   4  -5.0e3", "JMass"),
        ("   4  5.0e3", "   6  5.0e3", "CMJointID"),
        ("4   NMembers", "400   NMembers", "NMembers"),
        ("5   NJoints", "-1   NJoints", "NJoints"),
        ("3   NReact", "-1   NReact", "NReact"),
        ("2   NInterf", "0   NInterf", "NInterf"),
        ("3   FEMMod", "FEMModel", "FEMMod"),
        ("   2       1        1        1 ", "   2       1        1        x ", "RctTDZss"),
        ("0.8   2.0E-2", "0.8   0.5", "thickness_m"),
    ],
)
def test_refused_by_name(old, new, message):
    text = deck()
    assert old in text
    with pytest.raises(InputError, match=message):
        parse(text.replace(old, new, 1))
