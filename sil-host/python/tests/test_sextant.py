"""The module `sextant` by truths of its own: a photograph, Orion's seven, a drawn Earth, an orbit of Kepler.

Run by `cargo test -p sextant-python` and, installed by pip, by `tests/run long`.
"""

import os
import unittest
from pathlib import Path

import numpy as np
import sextant
from PIL import Image

DATA = os.environ.get("SEXTANT_DATA")
REFERENCE = Path(__file__).parents[2] / "cameras/reference.toml"

# Right ascension and declination, deg, J2000.0, by Hipparcos number, brightest first: Rigel, Betelgeuse, Bellatrix,
# Alnilam, Alnitak, Saiph, Mintaka.
ORION = {
    24436: (78.6345, -8.2016),
    27989: (88.7929, 7.4071),
    25336: (81.2828, 6.3497),
    26311: (84.0534, -1.2019),
    26727: (85.1897, -1.9426),
    27366: (86.9391, -9.6696),
    25930: (83.0017, -0.2991),
}


def unit(ra_deg, dec_deg):
    ra, dec = np.radians([ra_deg, dec_deg])
    return np.array([np.cos(dec) * np.cos(ra), np.cos(dec) * np.sin(ra), np.sin(dec)])


def looking_at(ra_deg, dec_deg, roll_deg):
    """Rotation matrix from ICRS to a sensor whose z looks there."""
    z = unit(ra_deg, dec_deg)
    x = np.cross([0.0, 0.0, 1.0], z)
    x /= np.linalg.norm(x)
    y = np.cross(z, x)
    cosine, sine = np.cos(np.radians(roll_deg)), np.sin(np.radians(roll_deg))
    return np.array([cosine * x + sine * y, cosine * y - sine * x, z])


def matrix(quaternion):
    """Rotation matrix of [x, y, z, w], by which v' = q* v q: a turn of the axes."""
    x, y, z, w = quaternion
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    vector = np.array([x, y, z])
    return (w * w - vector @ vector) * np.eye(3) + 2 * np.outer(vector, vector) - 2 * w * cross


def angle_arcsec(one, other):
    chord = np.linalg.norm(np.asarray(one) - np.asarray(other))
    return np.degrees(2 * np.arcsin(chord / 2)) * 3600


class Solve(unittest.TestCase):
    @unittest.skipUnless(DATA, "no data")
    def test_a_photograph_of_orions_belt(self):
        picture = np.asarray(Image.open(Path(DATA) / "sky/cedar-solve/orion_belt.jpg").convert("L"))
        for optics in ({"fov_deg": 10.1}, {}):
            answer = sextant.solve(picture, **optics)
            self.assertTrue(answer.identified, answer.reason)
            self.assertLessEqual({26311, 26727, 25930}, set(answer.hip.tolist()))
            self.assertEqual(answer.star_px.shape, (len(answer.hip), 2))
            self.assertEqual(answer.residual_px.shape, answer.star_px.shape)
            self.assertGreaterEqual(len(answer.spots_px), len(answer.hip))
            self.assertAlmostEqual(answer.fov_deg, 10.1, delta=0.3)
            self.assertLess(answer.false_id_probability, 1e-3)
            # The attitude maps Alnilam to where it was measured.
            star = matrix(answer.quaternion) @ unit(*ORION[26311])
            rows, columns = picture.shape
            focal_px = columns / 2 / np.tan(np.radians(answer.fov_deg / 2))
            place = star[:2] / star[2] * focal_px + [(columns - 1) / 2, (rows - 1) / 2]
            measured = answer.star_px[answer.hip.tolist().index(26311)]
            self.assertLess(np.linalg.norm(place - measured), 3.0)
            self.assertTrue(np.all(answer.sigma_arcsec > 0))
            # The middle of the picture is where z looks.
            middle = unit(answer.ra_deg, answer.dec_deg)
            self.assertLess(angle_arcsec(matrix(answer.quaternion)[2], middle), 300)

    def test_a_dark_is_an_answer_with_a_reason(self):
        answer = sextant.solve(np.full((480, 640), 9, np.uint16), fov_deg=15)
        self.assertFalse(answer.identified)
        self.assertEqual(answer.reason, "every pixel has the same value")
        self.assertIsNone(answer.quaternion)
        self.assertEqual((answer.hip.shape, answer.star_px.shape), ((0,), (0, 2)))

    def test_bad_input_is_one_line(self):
        dark = np.zeros((480, 640), np.uint8)
        for image, optics, words in [
            (dark.astype(float), {"fov_deg": 15}, "uint8 or uint16"),
            (dark[0], {"fov_deg": 15}, "(rows, columns)"),
            (dark[:8], {"fov_deg": 15}, "640 x 8 px"),
            (dark, {"fov_deg": 200}, "fov_deg: 200"),
            (dark, {"fov_deg": 0.5}, "no catalogue serves a field"),
            (dark, {"camera": "no-such.toml"}, "no-such.toml"),
            (dark, {"camera": REFERENCE}, "the picture has 640 x 480 px"),
            (dark, {"camera": REFERENCE, "fov_deg": 15}, "twice"),
        ]:
            with self.assertRaises(ValueError) as raised:
                sextant.solve(image, **optics)
            message = str(raised.exception)
            self.assertIn(words, message)
            self.assertNotIn("\n", message)
            self.assertNotIn("--", message)


class Identify(unittest.TestCase):
    def setUp(self):
        self.attitude = looking_at(83.8, -1.5, 25.0)
        self.vectors = np.array([self.attitude @ unit(*place) for place in ORION.values()])

    def test_orions_seven(self):
        answer = sextant.identify(self.vectors, fov_deg=25)
        self.assertTrue(answer.identified, answer.reason)
        self.assertEqual(answer.hip.tolist(), list(ORION))
        # Proper motion, aberration and a tenth of a pixel of 88 arcsec.
        error = matrix(answer.quaternion) @ self.attitude.T
        self.assertLess(np.degrees(np.arccos(min(1.0, (np.trace(error) - 1) / 2))) * 3600, 60)

    def test_brightness_gives_the_order(self):
        turned = self.vectors[::-1]
        answer = sextant.identify(turned, fov_deg=25, brightness=range(len(turned)))
        self.assertEqual(answer.hip.tolist(), list(ORION)[::-1])

    def test_two_stars_are_too_few(self):
        answer = sextant.identify(self.vectors[:2], fov_deg=25)
        self.assertEqual((answer.identified, answer.reason), (False, "fewer than three stars"))
        self.assertEqual(answer.hip.tolist(), [0, 0])

    def test_bad_input_is_one_line(self):
        for vectors, more, words in [
            (self.vectors[:, :2], {"fov_deg": 25}, "(n, 3)"),
            (-self.vectors, {"fov_deg": 25}, "vectors[0]"),
            (self.vectors * np.nan, {"fov_deg": 25}, "vectors[0]"),
            (self.vectors, {}, "give camera or fov_deg"),
            (self.vectors, {"fov_deg": 25, "brightness": [1.0]}, "brightness"),
        ]:
            with self.assertRaisesRegex(ValueError, words.replace("(", r"\(").replace(")", r"\)").replace("[", r"\[")):
                sextant.identify(vectors, **more)


class EarthInPictures(unittest.TestCase):
    # The Earth as a mean sphere, seen from 42,164 km, 1 deg beside the line of sight.
    RADIUS_KM, DISTANCE_KM = 6371.0, 42_164.0
    SIDE, FOV_DEG = 800, 24.0

    def picture(self):
        focal_px = self.SIDE / 2 / np.tan(np.radians(self.FOV_DEG / 2))
        direction = np.array([np.sin(np.radians(1.0)), 0.0, np.cos(np.radians(1.0))])
        at = np.arange(self.SIDE) - (self.SIDE - 1) / 2
        x, y = np.meshgrid(at / focal_px, at / focal_px)
        rays = np.stack([x, y, np.ones_like(x)], axis=-1)
        rays /= np.linalg.norm(rays, axis=-1, keepdims=True)
        from_centre = np.arccos(np.clip(rays @ direction, -1, 1))
        limb = np.arcsin(self.RADIUS_KM / self.DISTANCE_KM)
        edge_px = (limb - from_centre) * focal_px
        lit = 120 / (1 + np.exp(-edge_px / 0.8))
        noise = np.random.default_rng(1).normal(10, 2, lit.shape)
        return np.clip(lit + noise, 0, 255).round().astype(np.uint8), direction

    def test_a_drawn_earth(self):
        picture, direction = self.picture()
        answer = sextant.earth(picture, fov_deg=self.FOV_DEG)
        self.assertTrue(answer.found, answer.reason)
        self.assertLess(angle_arcsec(answer.direction, direction), 4 * answer.sigma_deg * 3600)
        self.assertLess(answer.sigma_deg, 0.05)
        self.assertAlmostEqual(answer.distance_km, self.DISTANCE_KM, delta=4 * answer.sigma_distance_km)
        self.assertEqual(answer.limb_px.shape, (len(answer.inliers), 2))
        self.assertEqual(answer.inliers.dtype, bool)
        self.assertGreater(answer.inliers.sum(), 20)

    def test_a_dark_has_none_and_bad_input_is_one_line(self):
        dark = np.zeros((480, 640), np.uint8)
        answer = sextant.earth(dark, fov_deg=24)
        self.assertEqual((answer.found, answer.direction), (False, None))
        for more, words in [
            ({}, "give camera or fov_deg"),
            ({"fov_deg": 24, "pole": [0, 0]}, "pole"),
            ({"fov_deg": 24, "sun": [0, 0, 0]}, "sun"),
        ]:
            with self.assertRaisesRegex(ValueError, words):
                sextant.earth(dark, **more)


class Propagate(unittest.TestCase):
    MU = 398_600.4418

    def setUp(self):
        self.r, self.v = np.array([7000.0, 0, 0]), np.array([0, np.sqrt(self.MU / 7000.0), 0])
        self.period_s = 2 * np.pi * np.sqrt(7000.0**3 / self.MU)

    def test_a_circle_of_kepler_closes(self):
        times = 100.0 + np.array([0.25, 0.5, 0.75, 1.0]) * self.period_s
        r, v = sextant.propagate(100.0, self.r, self.v, times, dynamics="kepler")
        self.assertEqual((r.shape, v.shape), ((4, 3), (4, 3)))
        # Times are kept to the microsecond: 8 mm of way.
        np.testing.assert_allclose(r[0], [0, 7000, 0], atol=1e-4)
        np.testing.assert_allclose(r[3], self.r, atol=1e-4)
        np.testing.assert_allclose(v[3], self.v, atol=1e-7)

    def test_the_flattening_turns_the_node(self):
        # -3/2 J2 (R / a)^2 n cos i, with the Earth's J2 and radius, over a day.
        inclination = np.radians(60.0)
        v = np.linalg.norm(self.v) * np.array([0, np.cos(inclination), np.sin(inclination)])
        day = np.array([86_400.0])
        turned = []
        for dynamics in ("kepler", "j2"):
            [r], [w] = sextant.propagate(0.0, self.r, v, day, dynamics=dynamics)
            h = np.cross(r, w)
            turned.append(np.degrees(np.arctan2(h[0], -h[1])))
        expected = np.degrees(-1.5 * 1.08263e-3 * (6378.137 / 7000) ** 2 * 2 * np.pi / self.period_s * 0.5) * 86_400
        self.assertAlmostEqual(turned[0], 0.0, places=6)
        self.assertAlmostEqual(turned[1], expected, delta=0.02 * abs(expected))

    def test_about_the_moon_its_pull_counts(self):
        # A circle of 2,437 km closes after 2 pi sqrt(r^3 / mu), mu = 4,902.8 km3/s2.
        speed = np.sqrt(4902.8 / 2437)
        period_s = 2 * np.pi * 2437 / speed
        r, _ = sextant.propagate(0.0, [2437.0, 0, 0], [0, 0, speed], [period_s], body="moon", dynamics="kepler")
        np.testing.assert_allclose(r[0], [2437.0, 0, 0], atol=0.05)

    def test_out_of_the_bounds_rows_are_nan(self):
        r, v = sextant.propagate(0.0, self.r, [0, 5, 0], [10.0, 3000.0], dynamics="kepler")
        self.assertTrue(np.isfinite(r[0]).all() and np.isnan(r[1]).all() and np.isnan(v[1]).all())

    def test_bad_input_is_one_line(self):
        for arguments, more, words in [
            ((0.0, self.r / 2, self.v, [1.0]), {}, "no state of a satellite"),
            ((0.0, self.r[:2], self.v, [1.0]), {}, "r_km: give three finite numbers"),
            ((0.0, self.r, self.v * np.nan, [1.0]), {}, "v_km_s"),
            ((0.0, self.r, self.v, [1e12]), {}, "times_s"),
            ((np.nan, self.r, self.v, [1.0]), {}, "t_s"),
            ((0.0, self.r, self.v, [1.0]), {"dynamics": "j3"}, "kepler, j2, full"),
            ((0.0, self.r, self.v, [1.0]), {"body": "venus"}, "earth, moon, mars"),
            ((0.0, self.r, self.v, [1.0]), {"drag_area_m2": 1.0}, "mass_kg"),
        ]:
            with self.assertRaisesRegex(ValueError, words):
                sextant.propagate(*arguments, **more)


class Documented(unittest.TestCase):
    def test_everything_says_what_it_takes_and_gives(self):
        self.assertRegex(sextant.__version__, r"^\d+\.\d+\.\d+$")
        for function in (sextant.solve, sextant.identify, sextant.earth, sextant.propagate):
            self.assertRegex(function.__doc__, r"(?s)float64|uint8.*Returns .*Raises ValueError")
        for answer in (sextant.Solution, sextant.Field, sextant.Earth):
            for name, member in vars(answer).items():
                if not name.startswith("_"):
                    self.assertTrue(member.__doc__, name)


if __name__ == "__main__":
    unittest.main()
