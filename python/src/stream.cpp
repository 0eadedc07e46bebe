// SPDX-License-Identifier: Apache-2.0
#include "bindings.h"
#include "checked_text.h"
#include "interruptible.h"

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include "knuckle/core/interrupted_by.h"
#include "knuckle/data/frame_stream.h"
#include "knuckle/prepare/open_source.h"

namespace knuckle::python {
namespace py = pybind11;

namespace {

constexpr const char* kDoc =
    R"(Frames as they come: an iterator over the Frames of a camera, a recording or a source played.

`for frame in stream` waits for each frame and ends with the stream. Where the next frame cannot be read,
knuckle.Error is raised; the loop may be begun again for the one after it, unless the device is lost. Ctrl-C ends the
waiting. One thread at a time may ask for a frame. `close()`, the end of a `with` block, lets the camera go, and ends
the waiting of another thread.)";

/// A stream that one thread may use at a time, and that can be let go of.
class OpenStream {
 public:
  explicit OpenStream(std::unique_ptr<FrameStream> stream) : stream_(std::move(stream)) {}

  std::optional<Frame> next() {
    if (is_closed_) return std::nullopt;
    const std::unique_lock lock(mutex_, std::try_to_lock);
    if (!lock) fail("stream: two threads ask for a frame at once; each needs a stream of its own");
    if (!stream_) return std::nullopt;
    const InterruptedBy closing(is_closed_);
    try {
      return stream_->next();
    } catch (const Interrupted&) {
      if (!is_closed_) throw;
      return std::nullopt;
    }
  }
  /// Ends the waiting of another thread, too.
  void close() {
    is_closed_ = true;
    const std::scoped_lock lock(mutex_);
    if (stream_) lost_frames_ = stream_->lost_frames();
    stream_.reset();
  }
  /// While another thread waits for a frame: as many as when nobody did.
  std::int64_t lost_frames() {
    const std::unique_lock lock(mutex_, std::try_to_lock);
    if (lock && stream_) lost_frames_ = stream_->lost_frames();
    return lost_frames_;
  }

 private:
  std::mutex mutex_;
  std::unique_ptr<FrameStream> stream_;
  std::atomic<bool> is_closed_ = false;
  std::atomic<std::int64_t> lost_frames_ = 0;
};

std::unique_ptr<OpenStream> open(const std::string& text) {
  const WithoutLock unlocked;
  return std::make_unique<OpenStream>(open_stream(checked_text(text, "stream")));
}

Frame next(OpenStream& stream) {
  std::optional<Frame> frame = interruptible([&] { return stream.next(); });
  if (!frame) throw py::stop_iteration();
  return *std::move(frame);
}

void close(OpenStream& stream) {
  const WithoutLock unlocked;
  stream.close();
}

std::int64_t lost_frames(OpenStream& stream) {
  const WithoutLock unlocked;
  return stream.lost_frames();
}

}  // namespace

void add_stream(py::module_& module) {
  py::class_<OpenStream>(module, "Stream", kDoc)
      .def("__iter__", [](py::object stream) { return stream; })
      .def("__next__", &next)
      .def("__enter__", [](py::object stream) { return stream; })
      .def("__exit__", [](OpenStream& stream, const py::args&) { close(stream); })
      .def("close", &close,
           "Lets the camera or file go; the stream has ended then, also for a thread that waits in it.")
      .def("__reduce__", &refuse_to_pickle)
      .def_property_readonly(
          "lost_frames", &lost_frames,
          "Frames that a camera took but that never came, so far; while another thread waits "
          "for one: when it was asked last.");
  module.def(
      "open_stream", &open, py::arg("text"),
      "Opens a camera, a recording or a source as a stream: `KIND:PATH[?key=value&...]`, as `knuckle live "
      "--source` takes it.\n\nReturns a Stream. Raises knuckle.Error where there is no such kind, or it "
      "cannot be opened.");
}

}  // namespace knuckle::python
