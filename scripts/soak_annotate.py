# SPDX-License-Identifier: Apache-2.0
"""The part of scripts/soak.py that labels: a scripted person, whose program is killed and begun again. What the program has accepted and
written is there after each start; and in the end each hand has the history that it has undisturbed."""
import json
import pathlib
import random
import shutil
import signal
import struct
import threading
import time
import urllib.error
import urllib.request

from soak_place import LONGEST_S, Started


FOCAL_PX = 45.0        # of soak.py's camera
MOST_MODEL_MM = 20.0   # that the model may end elsewhere after a start


def clicked(joint, camera, chance, by_pixel):
    """A landmark, with a tremble: a pixel, whose depth the hand model has a say in, or a point, which is taken as it is."""
    u, v = (value + chance.gauss(0, 0.4) for value in joint[:2])
    if by_pixel:
        return {"act": "place", "pixel": [round(u, 2), round(v, 2)]}
    depth = joint[2]
    return {"act": "move", "point_mm": [round((u - camera["cx"]) / camera["fx"] * depth, 2), round((v - camera["cy"]) / camera["fy"] * depth, 2),
                                        round(depth, 2)]}


def acts_on(frame, joints, camera, chance):
    by_model = moves_by_model(frame)
    names = chance.sample(sorted(joints), 6)
    place = [{**clicked(joints[name], camera, chance, by_model), "landmark": name} for name in names]
    acts = [place[0], place[1], {"act": "look", "landmark": names[2], "visible": False}, place[3], {"act": "undo"}, {"act": "redo"}, place[4],
            {"act": "free", "landmark": names[4]}, {"act": "brush", "points": [joints[names[5]][:2]], "radius_px": 2, "erases": False},
            {"act": "verify"}]
    return [*acts[:-1], {"act": "outline"}, acts[-1]] if by_model else acts


def script_of(truth, camera, seed):
    """What the person does to each frame: requests without their revision. `truth`: u, v, d of each landmark of each frame."""
    script = []
    for frame, joints in enumerate(truth):
        for act in acts_on(frame, joints, camera, random.Random(f"{seed} {frame}")):
            where = {} if act["act"] in ("undo", "redo") else {"frame": frame, "side": "right", "seconds": 1, "model": moves_by_model(frame)}
            script.append((frame, {**act, **where}))
    return script


def truth_of(folder, names):
    """Of a folder set, by frame and landmark."""
    frames = []
    for line in (folder / "joints.txt").read_text().splitlines():
        numbers = [float(number) for number in line.split()]
        frames.append({name: numbers[3 * i:3 * i + 3] for i, name in enumerate(names)})
    return frames


def histories(file):
    """Of each hand, without the times of day."""
    hands = {}
    for line in file.read_text().splitlines()[1:]:
        change = json.loads(line)
        change.pop("time")
        hands.setdefault((change["frame"], change["side"]), []).append(change)
    return hands


def moves_by_model(frame):
    """In every second frame the hand model moves what was not corrected."""
    return frame % 2 == 1


def without_model(change):
    """What the person alone has said: the model's part begins anew with each start of the program, so it may end a bit elsewhere."""
    said = {name: landmark and landmark[:2] + (landmark[2:4] if landmark[0] in ("corrected", "verified") and landmark[1] == "visible" else [])
            for name, landmark in change["landmarks"].items()}
    if change["act"] in ("undo", "redo", "verify"):
        said = {name: landmark and landmark[:2] for name, landmark in said.items()}
    return {**{key: value for key, value in change.items() if key != "mask"}, "landmarks": said}


def said_in(hands):
    return {hand: [without_model(change) if moves_by_model(hand[0]) else change for change in changes] for hand, changes in hands.items()}


def farthest_mm(ours, whole):
    """How far the model's part of two histories is apart, in depth and across."""
    most = 0.0
    for hand, changes in ours.items():
        for change, expected in zip(changes, whole[hand], strict=True):
            for name, landmark in change["landmarks"].items():
                if landmark:
                    other = expected["landmarks"][name]
                    across = max(abs(landmark[i] - other[i]) for i in (2, 3)) * landmark[4] / FOCAL_PX
                    most = max(most, across, abs(landmark[4] - other[4]))
    return most


class Served(Started):
    """`knuckle annotate`, once it serves; `address` is None where it has ended before."""

    def __init__(self, place, who, source, labels):
        super().__init__(place, who, ["annotate", "--source", f"folder:{source}", "--labels", labels, "--prelabel", "pipelines/default.toml",
                                      "--follow", "0", "--port", "0", "--threads", "1"])
        self.address = self.wait_for_line(r"annotate: (http://\S+/)\n")

    def ask(self, path, body=None):
        data = None if body is None else json.dumps(body).encode()
        with urllib.request.urlopen(urllib.request.Request(self.address + path, data=data), timeout=LONGEST_S) as answer:
            return answer.read()

    def revision(self, frame):
        """Of its right hand; 0: nothing is labelled."""
        message = self.ask(f"api/frame?index={frame}")
        header = json.loads(message[4:4 + struct.unpack_from("<I", message)[0]])
        return max((hand["revision"] for hand in header["labels"] if hand["side"] == "right"), default=0)


class Person:
    """Goes through the script, and knows what was accepted."""

    def __init__(self, place, who, script):
        self.place, self.who, self.script = place, who, script
        self.done = []  # (frame, revision after it) of each step
        self.kept = 0   # so many of these were on the disk
        self.on_its_way = None  # (frame, revision before it)

    def is_ready(self):
        return len(self.done) == len(self.script) == self.kept

    def catch_up(self, served):
        """After a start: what is on the disk. All that was said to be there has to be."""
        if self.on_its_way:
            frame, before = self.on_its_way
            revision = served.revision(frame)  # fails where the program is killed once more
            self.on_its_way = None
            if revision == before + 1:
                self.done.append((frame, before + 1))
                self.kept = len(self.done)
                return
        while self.done and served.revision(self.done[-1][0]) != self.done[-1][1]:
            self.done.pop()
        if len(self.done) < self.kept:
            self.place.log.broken(self.who, f"of {self.kept} accepted changes {len(self.done)} are there after a start")
        self.kept = len(self.done)

    def work(self, served, pause):
        while not self.is_ready():
            if len(self.done) < len(self.script):
                self.step(served)
            else:
                self.ask_whether_written(served)
            pause()

    def step(self, served):
        frame, request = self.script[len(self.done)]
        before = self.first_revision(served, frame)
        self.on_its_way = (frame, before)
        answer = self.post(served, {**request, "revision": before} if "frame" in request else request)
        after = served.revision(frame) if answer["refused"] or answer["remark"] else self.revision_in(answer)
        self.on_its_way = None
        if answer["refused"]:
            self.place.log.broken(self.who, f"step {len(self.done)} was refused: {answer['remark']}")
        self.done.append((frame, after))
        self.note_waiting(answer)

    def first_revision(self, served, frame):
        """Its newest; of a frame that is opened, once the pipeline has found its hand."""
        if self.done and self.done[-1][0] == frame:
            return self.done[-1][1]
        end = time.monotonic() + LONGEST_S
        while (revision := served.revision(frame)) == 0:
            if time.monotonic() > end:
                self.place.log.broken(self.who, f"no hand was found in frame {frame}")
                break
            time.sleep(0.05)
        return revision

    @staticmethod
    def post(served, request):
        try:
            return json.loads(served.ask("api/labels", request))
        except urllib.error.HTTPError as refusal:
            return {"refused": True, "remark": refusal.read().decode(), "waiting": 0}

    @staticmethod
    def revision_in(answer):
        return next(hand["revision"] for hand in answer["labels"] if hand["side"] == "right")

    def note_waiting(self, answer):
        if answer["waiting"] == 0:
            self.kept = len(self.done)
        else:
            self.place.log.count(self.who, "answers while changes waited in memory")

    def ask_whether_written(self, served):
        frame, revision = self.done[-1]
        request = {"act": "verify", "frame": frame, "side": "right", "revision": revision, "preview": True}
        self.note_waiting(self.post(served, request))


class Annotating:
    who = "annotate"

    def __init__(self, place, source):
        self.place, self.source = place, source
        self.chance = random.Random(f"{place.seed} {self.who}")
        self.whole = place.folder / "whole" / self.who
        self.seconds = 0.0
        self.farthest_mm = 0.0

    def begin(self):
        """The undisturbed person."""
        served = Served(self.place, self.who, self.source, self.whole)
        info = json.loads(served.ask("api/info"))
        self.script = script_of(truth_of(self.source, info["landmarks"]), info["camera"], self.place.seed)
        start = time.monotonic()
        Person(self.place, self.who, self.script).work(served, lambda: None)
        self.seconds = time.monotonic() - start
        served.kill(signal.SIGINT)
        served.end(LONGEST_S)
        self.export(self.whole, self.whole / "poses.txt")

    def run(self):
        rounds = 0
        while not self.place.calm.is_set():
            rounds += 1
            labels = self.place.disk.folder / f"{self.who}-{rounds}"
            person = Person(self.place, self.who, self.script)
            known = len(self.place.log.faults)
            while not person.is_ready() and len(self.place.log.faults) < known + 20:
                self.go_on(person, labels)
            self.compare(rounds, labels)
            shutil.rmtree(labels)
        self.place.log.say(self.who, f"where the hand model moves landmarks, they were at most {self.farthest_mm:.1f} mm from those without a new start")

    def go_on(self, person, labels):
        """From a start of the program to its end."""
        served = Served(self.place, self.who, self.source, labels)
        if not served.address:
            served.end(LONGEST_S)
            time.sleep(0.5)
            return
        killer = self.killer_of(served)
        try:
            person.catch_up(served)
            person.work(served, lambda: time.sleep(self.chance.uniform(0.0, 0.2)))
        except (OSError, urllib.error.URLError, ValueError) as fault:
            if not served.sent:
                self.place.log.broken(self.who, f"does not answer: {fault}")
        if killer:
            killer.cancel()
        if served.sent:
            self.place.log.count(self.who, "kills")
        served.kill(signal.SIGINT)
        served.end(LONGEST_S)

    def killer_of(self, served):
        if self.place.calm.is_set() or self.chance.random() < 0.2:
            return None
        which = signal.SIGKILL if self.chance.random() < 0.7 else signal.SIGTERM
        killer = threading.Timer(self.chance.uniform(0.0, 0.1 * len(self.script)), served.kill, [which])
        killer.start()
        return killer

    def export(self, labels, out):
        if self.place.retried("labels-export", ["labels", "export", "--source", f"folder:{self.source}", "--labels", labels, "--format", "poses",
                                                "--out", out]) is None:
            self.place.log.broken(self.who, "cannot be exported")

    def compare(self, rounds, labels):
        self.place.log.count(self.who, "rounds")
        self.place.log.count(self.who, "changes accepted", len(self.script))
        self.place.log.count(self.who, "comparisons", 2)
        ours, whole = histories(labels / "labels.jsonl"), histories(self.whole / "labels.jsonl")
        if said_in(ours) != said_in(whole):
            self.differs(rounds, "labels.jsonl", labels)
        else:
            self.farthest_mm = max(self.farthest_mm, farthest_mm(ours, whole))
            if self.farthest_mm > MOST_MODEL_MM:
                self.differs(rounds, "labels.jsonl", labels)
        self.export(labels, labels / "poses.txt")
        if self.exported(labels) != self.exported(self.whole):
            self.differs(rounds, "poses.txt", labels)

    @staticmethod
    def exported(labels):
        """Head, and the frames in which no model moves anything."""
        head, *frames = (labels / "poses.txt").read_text().splitlines()
        return [head, *(line for frame, line in enumerate(frames) if not moves_by_model(frame))]

    def differs(self, rounds, name, labels):
        self.place.log.count(self.who, "differences")
        self.place.log.broken(self.who, f"round {rounds}: {name} is another than undisturbed")
        shutil.copy(pathlib.Path(labels) / name, self.place.folder / f"{self.who}-{rounds}-{name}")
