// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/mkv_source.h"

#include <algorithm>
#include <array>
#include <utility>

#include "knuckle/core/error.h"
#include "knuckle/core/limits.h"
#include "knuckle/core/text.h"
#include "knuckle/data/readers/azure_calibration.h"
#include "knuckle/data/readers/depth_image.h"
#include "knuckle/data/readers/folder_format.h"

namespace knuckle {
namespace {

constexpr std::string_view kDepthName = "DEPTH";
constexpr std::string_view kInfraredName = "IR";
constexpr std::size_t kShownNameBytes = 40;
constexpr std::size_t kShownTracks = 16;
constexpr const char* kHowToGiveACamera = "give the camera by ?camera=FILE.toml";

/// The four characters that name the pixels of a track; empty where it is compressed.
std::string pixel_code_of(const MatroskaTrack& track) {
  constexpr std::size_t kCodeAt = 16;  // in Windows' BITMAPINFOHEADER
  constexpr std::size_t kCodeBytes = 4;
  if (track.codec == "V_UNCOMPRESSED") return track.colour_space;
  if (track.codec != "V_MS/VFW/FOURCC" || track.codec_private.size() < kCodeAt + kCodeBytes) return "";
  const auto code = track.codec_private.begin() + kCodeAt;
  return {code, code + kCodeBytes};
}

/// Whether 16-bit samples of that code are big-endian; nothing where it is another code. Those that are no
/// text are libavformat's for gray16be and gray16le.
std::optional<bool> is_big_endian_code(std::string_view code) {
  using std::string_view_literals::operator""sv;
  if (code == "b16g" || code == "\x10\0001Y"sv) return true;
  if (code == "Y16 " || code == "Y1\0\x10"sv) return false;
  return std::nullopt;
}

std::string names_of_tracks(const std::vector<MatroskaTrack>& tracks) {
  std::vector<std::string> names;
  for (const MatroskaTrack& track : tracks) {
    names.push_back(printable(shortened(track.name, kShownNameBytes)));
    if (names.size() == kShownTracks) break;
  }
  return names.empty() ? "none" : joined(names);
}

}  // namespace

void MkvOptions::visit(OptionVisitor& visitor) {
  visitor.text("camera", camera);
}

MkvSource::MkvSource(std::filesystem::path path, const MkvOptions& options)
    : file_(std::move(path)),
      depth_track_(require_depth_track()),
      infrared_track_(find_track(kInfraredName)),
      depth_(find_blocks()),
      infrared_(find_infrared()),
      camera_(find_camera(options.camera)) {}

/// The value of a tag, of the file or of a track; empty where there is none.
std::string MkvSource::tag(std::string_view name) const {
  const auto found = std::ranges::find(file_.tags(), name, &MatroskaTag::name);
  return found == file_.tags().end() ? "" : found->value;
}

/// The track that the tag K4A_..._TRACK is of, or whose number it says; else that of the name.
std::optional<MkvSource::SampleTrack> MkvSource::find_track(std::string_view name) const {
  const auto tag = std::ranges::find(file_.tags(), fmt::format("K4A_{}_TRACK", name), &MatroskaTag::name);
  const auto& tracks = file_.tracks();
  auto track = tracks.end();
  if (tag != file_.tags().end()) {
    track = std::ranges::find_if(tracks, [&](const MatroskaTrack& one) {
      return tag->track_uid ? one.uid == *tag->track_uid : fmt::format("{}", one.uid) == tag->value;
    });
  }
  if (track == tracks.end()) track = std::ranges::find(tracks, name, &MatroskaTrack::name);
  if (track == tracks.end()) return std::nullopt;

  const std::string where = fmt::format("{}: track {}", file_.path().string(), name);
  const std::string code = pixel_code_of(*track);
  const std::optional<bool> is_big_endian = is_big_endian_code(code);
  if (track->is_encoded || !is_big_endian) {
    fail("{}: has the codec '{:.40}'{}, expected samples of 16 bits: b16g or Y16", where,
         printable(code.empty() ? track->codec : code), track->is_encoded ? ", compressed" : "");
  }
  const auto most = static_cast<std::uint64_t>(limits::kImageSide);
  if (track->width < 1 || track->height < 1 || track->width > most || track->height > most) {
    fail("{}: has images of {}x{} pixels, expected 1 to {} a side", where, track->width, track->height, most);
  }
  return SampleTrack{*track, *is_big_endian};
}

MkvSource::SampleTrack MkvSource::require_depth_track() const {
  const std::optional<SampleTrack> track = find_track(kDepthName);
  if (track) return *track;
  const std::string mode = printable(tag("K4A_DEPTH_MODE"));
  fail("{}: has no depth track{}; its tracks: {}", file_.path().string(),
       mode.empty() ? "" : fmt::format(" (depth mode {:.40})", mode), names_of_tracks(file_.tracks()));
}

std::vector<MatroskaBlock> MkvSource::find_blocks() const {
  std::vector<MatroskaBlock> blocks = file_.blocks_of(depth_track_.track);
  if (blocks.empty()) fail("{}: the depth track holds no image", file_.path().string());
  std::ranges::stable_sort(blocks, {}, &MatroskaBlock::time_ns);
  return blocks;
}

std::map<std::int64_t, MatroskaBlock> MkvSource::find_infrared() const {
  std::map<std::int64_t, MatroskaBlock> blocks;
  if (!infrared_track_) return blocks;
  const MatroskaTrack& depth = depth_track_.track;
  const MatroskaTrack& infrared = infrared_track_->track;
  if (infrared.width != depth.width || infrared.height != depth.height) {
    fail("{}: the infrared images have {}x{} pixels, expected {}x{} as the depth images",
         file_.path().string(), infrared.width, infrared.height, depth.width, depth.height);
  }
  for (const MatroskaBlock& block : file_.blocks_of(infrared)) blocks.try_emplace(block.time_ns, block);
  return blocks;
}

/// The text of the attachment.
std::string MkvSource::calibration() const {
  constexpr auto kMostBytes = static_cast<std::uint64_t>(limits::kRecordHeaderBytes);
  const std::string named = tag("K4A_CALIBRATION_FILE");
  const std::string name = named.empty() ? "calibration.json" : named;
  const auto found = std::ranges::find(file_.attachments(), name, &MatroskaAttachment::name);
  if (found == file_.attachments().end()) {
    fail("{}: has no calibration (the attachment {:.40}); {}", file_.path().string(), printable(name),
         kHowToGiveACamera);
  }
  if (found->bytes > kMostBytes) {
    fail("{}: its calibration has {} bytes, expected at most {}", file_.path().string(), found->bytes,
         kMostBytes);
  }
  const std::vector<std::uint8_t> bytes = file_.read(found->at, found->bytes);
  // The recorder ends it with a 0.
  return {bytes.begin(), std::ranges::find(bytes, std::uint8_t{0})};
}

Camera MkvSource::find_camera(const std::string& file) const {
  const MatroskaTrack& track = depth_track_.track;
  const std::string name = file_.path().string();
  const Camera camera =
      file.empty() ? parse_azure_calibration(calibration(), tag("K4A_DEPTH_MODE"), name + ": its calibration")
                   : read_camera_file(file);
  if (track.width != static_cast<std::uint64_t>(camera.width) ||
      track.height != static_cast<std::uint64_t>(camera.height)) {
    fail("{}: the depth images have {}x{} pixels, and {} has {}x{}", name, track.width, track.height,
         file.empty() ? "the depth mode" : file, camera.width, camera.height);
  }
  return camera;
}

FrameLabel MkvSource::read_label(std::int64_t index) const {
  const MatroskaBlock& block = depth_.at(static_cast<std::size_t>(index));
  return {
      camera_,     std::nullopt, 1e-9 * static_cast<double>(block.time_ns), 0, fmt::format("{:06}", index),
      std::nullopt};
}

Image<std::uint16_t> MkvSource::read_samples(const MatroskaBlock& block, bool is_big_endian,
                                             std::string_view where) const {
  const std::uint64_t expected = std::uint64_t{2} * camera_.width * camera_.height;
  if (block.bytes != expected)
    fail("{}: has an image of {} bytes, expected {}", where, block.bytes, expected);
  const std::vector<std::uint8_t> bytes = file_.read(block.at, block.bytes);
  Image<std::uint16_t> samples(camera_.width, camera_.height);
  const std::uint8_t* from = bytes.data();
  for (std::uint16_t& sample : samples.pixels()) {
    sample = static_cast<std::uint16_t>(is_big_endian ? from[0] << 8 | from[1] : from[1] << 8 | from[0]);
    from += 2;
  }
  return samples;
}

Frame MkvSource::read(std::int64_t index) const {
  const MatroskaBlock& block = depth_.at(static_cast<std::size_t>(index));
  const std::string where = fmt::format("{}: frame {}", file_.path().string(), index);
  Frame frame;
  frame.name = fmt::format("{:06}", index);
  frame.camera = camera_;
  frame.depth_mm = depth_from_counts(read_samples(block, depth_track_.is_big_endian, where), 1.0);
  const auto infrared = infrared_.find(block.time_ns);
  if (infrared != infrared_.end()) {
    frame.infrared =
        read_samples(infrared->second, infrared_track_->is_big_endian, where + ", its infrared image");
  }
  frame.time_s = 1e-9 * static_cast<double>(block.time_ns);
  return frame;
}

}  // namespace knuckle
