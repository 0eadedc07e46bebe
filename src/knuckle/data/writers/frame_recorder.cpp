// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/writers/frame_recorder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "knuckle/core/error.h"
#include "knuckle/core/interruption.h"
#include "knuckle/data/readers/depth_image.h"
#include "knuckle/data/readers/frame_log.h"
#include "knuckle/data/readers/h5_source.h"
#include "knuckle/data/writers/folder_writer.h"
#include "knuckle/data/writers/h5_writer.h"
#include "knuckle/storage/file_io.h"
#include "knuckle/storage/hdf5/hdf5_file.h"

namespace fs = std::filesystem;

namespace knuckle {
namespace {

constexpr std::size_t kMostWaiting = 120;  // four seconds of most cameras; 200 MB at 640 x 480
constexpr std::size_t kMostBlank = 60;     // frames that show nothing, before a unit is chosen without them

bool is_single_file(const fs::path& path) {
  return path.extension() == ".h5";
}

/// The file that frames come together in: the set itself, or what a folder is made of.
fs::path file_for(const fs::path& path) {
  return is_single_file(path) ? path : fs::path(path.string() + ".recording.h5");
}

fs::path log_of(const fs::path& path) {
  return file_for(path).string() + ".partial";
}

FrameWriterOptions writer_options(double unit_mm) {
  FrameWriterOptions options;
  options.depth_unit_mm = unit_mm;
  options.manifest = "# recorded frame by frame";
  return options;
}

std::string how_to_finish(const fs::path& path) {
  return fmt::format("`knuckle record --finish {}` makes a set of it", path.string());
}

void require_new(const fs::path& path) {
  std::error_code unknown;
  if (path.filename().empty()) fail("{}: expected a name without '/' at its end", path.string());
  if (fs::exists(path, unknown) && !fs::is_empty(path, unknown))
    fail("{}: is there already; remove it or choose another name", path.string());
  const fs::path rest = fs::exists(log_of(path), unknown) ? log_of(path) : file_for(path);
  if (rest != path && fs::exists(rest, unknown))
    fail("{}: is left of a recording that was cut short; {}", rest.string(), how_to_finish(path));
}

/// What a recording keeps of a frame.
Frame raw_frame(const Frame& frame) {
  Frame raw;
  raw.name = frame.name;
  raw.camera = frame.camera;
  raw.depth_mm = frame.depth_mm;
  raw.infrared = frame.infrared;
  raw.time_s = frame.time_s;
  return raw;
}

bool shows_something(const Image<float>& depth_mm) {
  return std::ranges::any_of(depth_mm.pixels(), is_measured);
}

/// Sets what 16 bits cannot hold to 0; whether there was any.
bool cut_beyond(Image<float>& depth_mm, double unit_mm) {
  constexpr double kMostCounts = 65535.0;
  bool is_cut = false;
  for (float& depth : depth_mm.pixels()) {
    if (depth / unit_mm + 0.5 < kMostCounts + 1 || !(depth > 0.0f)) continue;
    is_cut |= is_measured(depth);
    depth = 0.0f;
  }
  return is_cut;
}

bool are_alike(const Camera& a, const Camera& b) {
  return a.width == b.width && a.height == b.height && a.model == b.model && a.distortion == b.distortion;
}

template <class T>
bool has_size_of(const Image<T>& image, const Camera& camera) {
  return image.width() == camera.width && image.height() == camera.height;
}

/// A folder set of the frames of `file`, which has its name when it is whole.
void write_folder_set(const fs::path& file, const fs::path& path) {
  const fs::path partial = path.string() + ".partial";
  fs::remove_all(partial);  // of a run that was cut short; its frames are in `file`
  const H5Source source(file);
  FolderWriter writer(partial, writer_options(Hdf5File::open(file).number_attribute("depth_unit_mm")));
  for (std::int64_t i = 0; i < source.size(); ++i) {
    end_if_interrupted();
    Frame frame = raw_frame(source.read(i));
    frame.sequence = source.read_label(i).sequence;
    writer.write(i, frame);
  }
  writer.finish();
  std::error_code fault;
  fs::rename(partial, path, fault);
  if (fault) fail("{}: cannot be written: {}", path.string(), fault.message());
  sync_folder_of(path);  // before the only other copy of the frames goes
  fs::remove(file, fault);
}

void make_set(H5Writer& writer, const fs::path& path) {
  writer.finish();
  if (!is_single_file(path)) write_folder_set(file_for(path), path);
}

/// The writer that goes on with what a recording left.
std::unique_ptr<H5Writer> writer_of_rest(const fs::path& path) {
  if (!is_frame_log(log_of(path))) fail("{}: there is no such recording to finish", log_of(path).string());
  std::string fault;
  for (const double unit_mm : kDepthUnitsMm) {
    try {
      return std::make_unique<H5Writer>(file_for(path), writer_options(unit_mm));
    } catch (const Error& error) {  // another unit's
      fault = error.what();
    }
  }
  fail("{}", fault);
}

}  // namespace

FrameRecorder::FrameRecorder(fs::path path)
    : path_(std::move(path)), way_(kMostWaiting, HandOver<std::shared_ptr<const Frame>>::Lose::newest) {
  require_new(path_);
  check_writable(log_of(path_));
  thread_ = std::thread([this] { run(); });
}

FrameRecorder::~FrameRecorder() {
  way_.close();
  if (thread_.joinable()) thread_.join();
}

void FrameRecorder::put(std::shared_ptr<const Frame> frame) {
  if (has_failed_ || is_closed_) return;
  ++came_;
  way_.put(std::move(frame));
}

RecordingState FrameRecorder::state() const {
  const std::int64_t dropped = way_.lost() + unfit_;
  const std::lock_guard lock(fault_mutex_);
  const std::int64_t frames = has_failed_ ? written_.load() : came_ - dropped;
  return {path_.filename().string(), std::max<std::int64_t>(frames, 0), dropped, fault_};
}

void FrameRecorder::close() {
  is_closed_ = true;
  way_.close();
}

void FrameRecorder::run() {
  try {
    while (auto frame = way_.take()) take(*std::move(frame));
    make_whole();
  } catch (const Interrupted&) {  // `finish` tries again
  } catch (const std::exception& error) {
    {
      const std::lock_guard lock(fault_mutex_);
      fault_ = error.what();
      if (written_ > 0) {
        fault_ += fmt::format("; {} holds the {} frames until then: make room, and {}",
                              log_of(path_).string(), written_.load(), how_to_finish(path_));
      }
    }
    has_failed_ = true;
    way_.close();
    while (way_.take()) {
    }
  }
  has_ended_ = true;
}

void FrameRecorder::take(std::shared_ptr<const Frame> frame) {
  if (!fits(*frame)) {
    ++unfit_;
    return;
  }
  if (!first_) first_ = frame;
  blank_.push_back(std::move(frame));
  const Image<float>& depth = blank_.back()->depth_mm;
  if (!unit_mm_ && (shows_something(depth) || blank_.size() == kMostBlank)) choose_unit(depth);
  if (unit_mm_) write_waiting();
}

void FrameRecorder::choose_unit(const Image<float>& depth_mm) {
  unit_mm_ = suitable_depth_unit_mm(depth_mm);
  writer_ = std::make_unique<H5Writer>(file_for(path_), writer_options(*unit_mm_));
}

void FrameRecorder::write_waiting() {
  for (; !blank_.empty(); blank_.pop_front()) write(*blank_.front());
}

void FrameRecorder::write(const Frame& frame) {
  Frame raw = raw_frame(frame);
  raw.sequence = next_sequence(frame);
  if (cut_beyond(raw.depth_mm, *unit_mm_)) ++cut_;
  if (!is_exact_in(raw.depth_mm, *unit_mm_)) ++rounded_;
  writer_->write(written_, raw);
  ++written_;
}

bool FrameRecorder::fits(const Frame& frame) {
  if (frame.time_s && !std::isfinite(*frame.time_s)) return false;
  if (!has_size_of(frame.depth_mm, frame.camera)) return false;
  if (!frame.infrared.empty() && !has_size_of(frame.infrared, frame.camera)) return false;
  if (!first_) return true;
  const bool has_camera =
      is_single_file(path_) ? are_alike(frame.camera, first_->camera) : frame.camera == first_->camera;
  return has_camera && frame.infrared.empty() == first_->infrared.empty() &&
         frame.time_s.has_value() == first_->time_s.has_value();
}

/// The frame's own, or a new one where it, or the time, goes back.
int FrameRecorder::next_sequence(const Frame& frame) {
  const int sequence = frame.sequence + sequence_shift_;
  const bool is_first = written_ == 0;
  const bool goes_back =
      !is_first && (sequence < last_sequence_ || (sequence == last_sequence_ && frame.time_s < last_time_s_));
  if (goes_back) sequence_shift_ = last_sequence_ + 1 - frame.sequence;
  last_sequence_ = frame.sequence + sequence_shift_;
  last_time_s_ = frame.time_s;
  return last_sequence_;
}

void FrameRecorder::make_whole() {
  if (!unit_mm_ && !blank_.empty()) choose_unit(blank_.back()->depth_mm);
  if (unit_mm_) write_waiting();
  if (writer_ == nullptr) fail("{}: nothing was recorded: no frame came that could be", path_.string());
  make_set(*writer_, path_);
  is_whole_ = true;
}

std::vector<std::string> FrameRecorder::finish() {
  close();
  if (thread_.joinable()) thread_.join();
  if (has_failed_) throw Error(state().fault);
  if (!is_whole_) make_whole();
  return remarks();
}

std::vector<std::string> FrameRecorder::remarks() const {
  std::vector<std::string> remarks;
  const std::string name = path_.string();
  if (const std::int64_t lost = way_.lost(); lost > 0)
    remarks.push_back(fmt::format("{}: {} frames were dropped: the disk was too slow", name, lost));
  if (unfit_ > 0) {
    remarks.push_back(
        fmt::format("{}: {} frames were left out: their size, camera, time or images are of "
                    "another kind than the first one's",
                    name, unfit_.load()));
  }
  if (rounded_ > 0) {
    remarks.push_back(fmt::format("{}: the depth of {} frames was rounded to whole multiples of {} mm", name,
                                  rounded_, *unit_mm_));
  }
  if (cut_ > 0) {
    constexpr double kMostCounts = 65535.0;
    remarks.push_back(fmt::format("{}: in {} frames what is farther than {} mm was left out", name, cut_,
                                  kMostCounts * *unit_mm_));
  }
  return remarks;
}

std::int64_t finish_recording(const fs::path& path) {
  std::error_code unknown;
  if (!is_single_file(path) && fs::exists(file_for(path), unknown)) {  // only the folder is missing
    const std::int64_t frames = H5Source(file_for(path)).size();
    write_folder_set(file_for(path), path);
    return frames;
  }
  const auto writer = writer_of_rest(path);
  const std::int64_t frames = writer->size();
  make_set(*writer, path);
  return frames;
}

}  // namespace knuckle
