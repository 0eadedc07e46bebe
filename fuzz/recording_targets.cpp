// SPDX-License-Identifier: Apache-2.0
// Recordings of cameras.
#include "fuzz_target.h"

#include <algorithm>
#include <cstring>
#include <string_view>

#include "knuckle/data/readers/azure_calibration.h"
#include "knuckle/data/readers/fakenect_index.h"
#include "knuckle/data/readers/kinect_depth.h"
#include "knuckle/data/readers/mcap_source.h"
#include "knuckle/data/readers/mkv_source.h"
#include "knuckle/data/readers/pgm_image.h"
#include "knuckle/data/readers/rosbag_source.h"
#include "knuckle/stream/camera_messages.h"
#include "knuckle/stream/process_stream.h"

namespace knuckle::fuzz {

/// An image after the lines of an index, or either alone.
void run_fakenect(Bytes bytes) {
  const std::string_view text = as_text(bytes);
  const std::size_t image = text.find("P5");
  if (image != 0) (void)parse_fakenect_index(text.substr(0, image), "INDEX.txt");
  if (image == std::string_view::npos) return;
  const Image<std::uint16_t> stored = decode_pgm16(text.substr(image), "fuzz.pgm");
  (void)kinect_depth_mm(stored, kinect_format_of(stored, "", "fuzz.pgm"), "fuzz.pgm");
}

/// What a camera's process may say: a head, and then one of its messages.
void run_camera_messages(Bytes bytes) {
  CameraMessageHead head;
  if (bytes.size() < sizeof head + sizeof(PipedDescription)) return;
  std::memcpy(&head, bytes.data(), sizeof head);
  check(head, "fuzz");
  const auto rest = bytes.subspan(sizeof head);
  ReceivedMessage message{CameraMessage::frame, {rest.begin() + sizeof(PipedDescription), rest.end()}};
  const PipedDescription description = parse_description(rest.first(sizeof(PipedDescription)), "fuzz");
  (void)intrinsics_of(description);
  (void)parse_piped_frame(message.bytes, description, "fuzz");
  (void)depth_of(message, description, "fuzz");
}

namespace {

void read_first(const FrameSource& source) {
  for (std::int64_t i = 0; i < std::min<std::int64_t>(source.size(), 3); ++i) (void)source.read(i);
}

}  // namespace

void run_rosbag(Bytes bytes) {
  const FuzzFile file(bytes, ".bag");
  read_first(RosbagSource(file.path()));
}

void run_mcap(Bytes bytes) {
  const FuzzFile file(bytes, ".mcap");
  read_first(McapSource(file.path()));
}

/// A recording, whose camera comes from a file: images of its own would make it large; or a calibration.
void run_mkv(Bytes bytes) {
  if (as_text(bytes).starts_with("{")) {
    (void)parse_azure_calibration(as_text(bytes), "NFOV_UNBINNED", "calibration.json");
    return;
  }
  static const FuzzFile camera(as_bytes_of("[camera]\nwidth=16\nheight=12\nfx=15\nfy=15\ncx=8\ncy=6\n"),
                               ".toml");
  const FuzzFile file(bytes, ".mkv");
  read_first(MkvSource(file.path(), {.camera = camera.path().string()}));
}

}  // namespace knuckle::fuzz
