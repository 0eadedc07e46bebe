# SPDX-License-Identifier: Apache-2.0
"""Objects that __new__ made and __init__ did not: whatever they are asked for is a TypeError."""

import copyreg
import gc
import inspect
import unittest

import knuckle
from testing import demo_frames

CLASSES = [thing for name, thing in vars(knuckle).items()
           if name in knuckle.__all__ and inspect.isclass(thing) and not issubclass(thing, Exception)]
MADE_IN_PYTHON = {knuckle.Source}  # Python's own words: it has no such attribute


def uses_of(thing):
    """What all members of an object do when they are read, or called without arguments: name and function."""
    for name in dir(type(thing)):
        if name in {"__class__", "__init__", "__new__", "__del__"}:
            continue
        yield name, lambda name=name: getattr(thing, name)
        if callable(getattr(type(thing), name)):
            yield f"{name}()", lambda name=name: getattr(thing, name)()


class Unmade(unittest.TestCase):
    def test_all_classes_are_looked_at(self):
        self.assertEqual(len(CLASSES), 13)

    def test_whatever_they_are_asked_for_is_refused(self):
        for kind in CLASSES:
            subclass = type("Sub", (kind,), {})
            for make in (lambda kind=kind: kind.__new__(kind), lambda kind=kind: copyreg.__newobj__(kind),
                         lambda subclass=subclass: subclass.__new__(subclass)):
                thing = make()
                for name, use in uses_of(thing):
                    with self.subTest(f"{kind.__name__}.{name}"):
                        try:
                            use()
                        except TypeError as error:
                            self.assertNotIn("\0", str(error))
                        except AttributeError:
                            self.assertIn(kind, MADE_IN_PYTHON)
                for name in (name for name, member in vars(kind).items() if isinstance(member, property)):
                    with self.assertRaises(AttributeError if kind in MADE_IN_PYTHON else TypeError, msg=f"{kind.__name__}.{name}"):
                        getattr(thing, name)
                del thing
                gc.collect()

    def test_they_are_no_arguments(self):
        frame = demo_frames()[0]
        pipeline = knuckle.Pipeline.from_toml('[segmentation]\nmethod = "threshold"\n', estimator=knuckle.Estimator(len, "knuckle22"))
        for use in (lambda: pipeline.estimate(frame.depth_mm, knuckle.Camera.__new__(knuckle.Camera)),
                    lambda: frame.camera == knuckle.Camera.__new__(knuckle.Camera),
                    lambda: knuckle.Frame(frame.depth_mm, knuckle.Camera.__new__(knuckle.Camera)),
                    lambda: knuckle.Tracker(knuckle.Pipeline.__new__(knuckle.Pipeline)),
                    lambda: knuckle.Tracker(pipeline).update(knuckle.Frame.__new__(knuckle.Frame)),
                    lambda: knuckle.Pipeline.default(estimator=knuckle.Estimator.__new__(knuckle.Estimator)),
                    lambda: next(knuckle.Stream.__new__(knuckle.Stream)),
                    lambda: knuckle.evaluate("a.txt", {"a": "b.txt"}, camera=knuckle.Camera.__new__(knuckle.Camera))):
            with self.assertRaisesRegex(TypeError, "never made"):
                use()

    def test_one_can_still_be_made(self):
        camera = knuckle.Camera.__new__(knuckle.Camera)
        with self.assertRaises(TypeError):
            camera.fx  # pylint: disable=pointless-statement
        camera.__init__(1.0, 2.0, 3.0, 4.0, 5, 6)
        self.assertEqual(camera, knuckle.Camera(1.0, 2.0, 3.0, 4.0, 5, 6))


if __name__ == "__main__":
    unittest.main()
