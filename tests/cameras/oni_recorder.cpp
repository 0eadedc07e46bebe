// SPDX-License-Identifier: Apache-2.0
// Records OpenNI2's stand-in for a camera by OpenNI2's own recorder: oni_recorder OUT.oni OUT.raw FRAMES. The
// second file gets the pixels of the same frames as they came.
#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include <OpenNI.h>
#include <unistd.h>

int main(int count, char** arguments) {
  if (count != 4) return 2;
  if (openni::OpenNI::initialize() != openni::STATUS_OK) return 3;
  openni::Device device;
  openni::VideoStream stream;
  openni::Recorder recorder;
  if (device.open("Dummy") != openni::STATUS_OK) return 4;
  if (stream.create(device, openni::SENSOR_DEPTH) != openni::STATUS_OK) return 5;
  if (recorder.create(arguments[1]) != openni::STATUS_OK || recorder.attach(stream) != openni::STATUS_OK)
    return 6;
  if (recorder.start() != openni::STATUS_OK || stream.start() != openni::STATUS_OK) return 7;
  std::FILE* const raw = std::fopen(arguments[2], "wb");
  for (int i = 0; i < std::atoi(arguments[3]); ++i) {
    openni::VideoFrameRef frame;
    if (stream.readFrame(&frame) != openni::STATUS_OK) return 8;
    const std::uint64_t time_us = frame.getTimestamp();
    std::fwrite(&time_us, sizeof time_us, 1, raw);
    std::fwrite(frame.getData(), 1, static_cast<std::size_t>(frame.getDataSize()), raw);
  }
  std::fclose(raw);
  recorder.stop();
  recorder.destroy();
  ::_exit(0);  // OpenNI2 crashes where it is asked to end after a recording
}
