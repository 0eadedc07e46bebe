#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The simulation of scripts/scale_model.py against what can be said without one."""
import importlib.util
import math
import pathlib
import random
import statistics
import sys
import unittest

SCRIPT = pathlib.Path(__file__).resolve().parents[2] / "scripts/scale_model.py"
SPEC = importlib.util.spec_from_file_location("scale_model", SCRIPT)
MODEL = importlib.util.module_from_spec(SPEC)
sys.modules["scale_model"] = MODEL
SPEC.loader.exec_module(MODEL)


class Rendering(unittest.TestCase):
    def test_without_spread_and_failures_takes_the_parts_of_the_busiest_worker(self):
        calm = MODEL.Costs(spread=0.0, failure_h=1e12)
        for parts, workers in ((8, 4), (9, 4), (3, 5)):
            part_s = calm.start_s + calm.render_s * 1000 / parts
            took = MODEL.render_with_failures(calm, 1000, workers, parts, random.Random(1))
            self.assertAlmostEqual(took, part_s * math.ceil(parts / workers), places=9)

    def test_failures_cost_a_restart_each_and_nothing_twice(self):
        costs = MODEL.Costs(spread=0.0, failure_h=1.0, restart_s=60.0)
        frames = 5e6  # 14,000 s of one worker, in which it fails 3.9 times
        times = [MODEL.render_with_failures(costs, frames, 1, 1, random.Random(seed)) for seed in range(2000)]
        work = MODEL.rendering_s(costs, frames, 1)
        self.assertAlmostEqual(statistics.fmean(times) / (work + 60.0 * work / 3600.0), 1.0, delta=0.003)


class Forest(unittest.TestCase):
    def test_one_sends_nothing_and_two_send_what_was_measured(self):
        costs = MODEL.Costs()
        self.assertEqual(MODEL.forest_tree_s(costs, 1000, 1), costs.tree_s * 1000)
        sent = costs.moved_share * costs.patch_bytes * 1000 / costs.link_bytes_s
        self.assertAlmostEqual(MODEL.forest_tree_s(costs, 1000, 2), costs.tree_s * 500 + sent)
        self.assertEqual(MODEL.forest_worker_bytes(costs, 1000, 4), costs.patch_bytes * 250)


class Training(unittest.TestCase):
    def test_alone_exchanges_nothing_and_two_send_what_shard_sum_sends(self):
        costs = MODEL.Costs(latency_s=0.0)
        self.assertEqual(MODEL.exchange_s(costs, 1), 0.0)
        sent = (costs.shards / 2 + 1) / 2 * costs.gradient_bytes
        self.assertAlmostEqual(MODEL.exchange_s(costs, 2), sent / costs.link_bytes_s)

    def test_failures_take_the_time_that_theory_expects(self):
        # A stretch of t with failures at rate r, each of which costs a restart R: (1 / r + R) (exp(r t) - 1).
        interval, checkpoint, restart, failure = 500.0, 20.0, 100.0, 1000.0
        times = [MODEL.train_with_failures(20 * interval, interval, checkpoint, restart, failure, random.Random(seed))
                 for seed in range(3000)]
        expected = 20 * (failure + restart) * math.expm1((interval + checkpoint) / failure)
        self.assertAlmostEqual(statistics.fmean(times) / expected, 1.0, delta=0.02)

    def test_the_best_interval_is_better_than_half_and_twice_of_it(self):
        failure, checkpoint = 20000.0, 10.0
        best = MODEL.best_interval_s(checkpoint, failure)

        def mean(interval):
            return statistics.fmean(MODEL.train_with_failures(2e5, interval, checkpoint, 0.0, failure, random.Random(seed))
                                    for seed in range(2000))

        self.assertLess(mean(best), mean(0.3 * best))
        self.assertLess(mean(best), mean(3.0 * best))

    def test_one_worker_waits_for_nobody(self):
        costs = MODEL.Costs()
        alone = MODEL.straggling(costs, 1, random.Random(3), steps=20000)
        self.assertAlmostEqual(alone, math.exp(costs.spread**2 / 2), delta=0.005)
        self.assertGreater(MODEL.straggling(costs, 100, random.Random(3)), MODEL.straggling(costs, 10, random.Random(3)))


if __name__ == "__main__":
    unittest.main()
