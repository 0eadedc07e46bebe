// SPDX-License-Identifier: Apache-2.0
#include "bindings.h"
#include "interruptible.h"

#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include "knuckle/data/frame_stream.h"
#include "knuckle/prepare/open_source.h"

namespace knuckle::python {
namespace py = pybind11;

namespace {

constexpr const char* kDoc =
    R"(Frames as they come: an iterator over the Frames of a camera, a recording or a source played.

`for frame in stream` waits for each frame and ends with the stream. Where the next frame cannot be read,
knuckle.Error is raised; the loop may be begun again for the one after it, unless the device is lost. Ctrl-C ends the
waiting. One thread at a time may ask for a frame. `close()`, the end of a `with` block, lets the camera go.)";

/// A stream that one thread may use at a time, and that can be let go of.
class OpenStream {
 public:
  explicit OpenStream(std::unique_ptr<FrameStream> stream) : stream_(std::move(stream)) {}

  std::optional<Frame> next() {
    const std::unique_lock lock(mutex_, std::try_to_lock);
    if (!lock) fail("stream: two threads ask for a frame at once; each needs a stream of its own");
    if (!stream_) return std::nullopt;
    return stream_->next();
  }
  void close() {
    const std::scoped_lock lock(mutex_);
    stream_.reset();
  }
  std::int64_t lost_frames() {
    const std::scoped_lock lock(mutex_);
    return stream_ ? stream_->lost_frames() : 0;
  }

 private:
  std::mutex mutex_;
  std::unique_ptr<FrameStream> stream_;
};

std::unique_ptr<OpenStream> open(const std::string& text) {
  const WithoutLock unlocked;
  return std::make_unique<OpenStream>(open_stream(text));
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
      .def("close", &close, "Lets the camera or file go; the stream has ended then.")
      .def("__reduce__", &refuse_to_pickle)
      .def_property_readonly("lost_frames", &lost_frames,
                             "Frames that a camera took but that never came, so far.");
  module.def(
      "open_stream", &open, py::arg("text"),
      "Opens a camera, a recording or a source as a stream: `KIND:PATH[?key=value&...]`, as `knuckle live "
      "--source` takes it.\n\nReturns a Stream. Raises knuckle.Error where there is no such kind, or it "
      "cannot be opened.");
}

}  // namespace knuckle::python
