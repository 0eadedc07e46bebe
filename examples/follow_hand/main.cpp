// SPDX-License-Identifier: Apache-2.0
// Follows hands through the frames of a source, and writes a line for each in every frame: frame, id, side,
// and how far each finger is bent, thumb to little [degrees].
#include <cstdio>
#include <numbers>

#include <knuckle/core/resources.h>
#include <knuckle/data/frame_stream.h>
#include <knuckle/pipeline/pipeline.h>
#include <knuckle/prepare/open_source.h>
#include <knuckle/track/tracker.h>

/// All of a digit's flexions together.
double bent_deg(const knuckle::HandAngles& angles, int digit) {
  using enum knuckle::HandAngle;
  if (digit == 0) return (angles[thumb_mcp] + angles[thumb_ip]) * 180.0 / std::numbers::pi;
  const auto [mcp, spread, pip, dip] = knuckle::angles_of_finger(digit - 1);
  return (angles[mcp] + angles[pip] + angles[dip]) * 180.0 / std::numbers::pi;
}

int main(int argument_count, char** arguments) try {
  if (argument_count != 2) return std::fprintf(stderr, "usage: follow_hand SOURCE\n"), 2;
  knuckle::SourceStream stream(knuckle::open_source(arguments[1]));
  const auto pipeline = knuckle::Pipeline::load(knuckle::resource_path("pipelines/track.toml"));
  knuckle::Tracker tracker(pipeline, *pipeline.tracker());
  for (int number = 0; const auto frame = stream.next(); ++number) {
    for (const knuckle::TrackedHand& hand : tracker.update(*frame)) {
      std::printf("%d %d %s", number, hand.id, hand.side == knuckle::HandSide::left ? "left" : "right");
      for (int digit = 0; digit < 5; ++digit) std::printf(" %.0f", bent_deg(hand.angles, digit));
      std::puts("");
    }
  }
} catch (const std::exception& error) {
  return std::fprintf(stderr, "%s\n", error.what()), 1;
}
