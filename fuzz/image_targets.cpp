// SPDX-License-Identifier: Apache-2.0
// Images, HDF5 and labels, as data sets hold them.
#include "fuzz_target.h"

#include <algorithm>
#include <functional>
#include <initializer_list>
#include <optional>
#include <vector>

#include "knuckle/core/error.h"
#include "knuckle/data/readers/csv_image.h"
#include "knuckle/data/readers/exr_image.h"
#include "knuckle/data/readers/frame_log.h"
#include "knuckle/data/readers/h5_source.h"
#include "knuckle/data/readers/msra15_source.h"
#include "knuckle/data/readers/nyu_truth.h"
#include "knuckle/data/readers/png_decoder.h"
#include "knuckle/data/readers/stored_frame.h"
#include "knuckle/storage/hdf5/hdf5_file.h"

namespace knuckle::fuzz {

void run_png(Bytes bytes) {
  (void)decode_png(bytes, "fuzz.png");
}

void run_exr(Bytes bytes) {
  const FuzzFile file(bytes, ".exr");
  (void)read_exr(file.path());
}

void run_csv(Bytes bytes) {
  const FuzzFile file(bytes, ".csv");
  (void)read_csv_image(file.path());
}

void run_mat(Bytes bytes) {
  const FuzzFile file(bytes, ".mat");
  (void)NyuTruth(file.path(), 1).pose(0);
}

void run_msra15(Bytes bytes) {
  const FuzzFile file(bytes, ".bin");
  (void)read_msra15_depth(file.path());
}

void run_hdf5(Bytes bytes) {
  const FuzzFile file(bytes, ".h5");
  const Hdf5File hdf5 = Hdf5File::open(file.path());
  if (hdf5.has_attribute("format")) (void)hdf5.text_attribute("format");
  for (const char* name : {"depth", "joints_mm", "time_s"}) {
    if (hdf5.has(name)) (void)hdf5.read<float>(name);
  }
}

namespace {

/// Calls all of them, whichever of them throws; then throws the last Error.
void each_by_itself(std::initializer_list<std::function<void()>> readers) {
  std::optional<Error> fault;
  for (const std::function<void()>& read : readers) {
    try {
      read();
    } catch (const Error& error) {
      fault = error;
    }
  }
  if (fault) throw *fault;
}

}  // namespace

/// What `inspect`, `evaluate` and `join` read of a set.
void run_h5_set(Bytes bytes) {
  const FuzzFile file(bytes, ".h5");
  const H5Source source(file.path());
  (void)source.facts();
  for (std::int64_t i = 0; i < std::min<std::int64_t>(source.size(), 3); ++i) {
    each_by_itself({[&] { (void)source.read(i); }, [&] { (void)source.read_label(i); },
                    [&] { (void)stored_frame_from(to_bytes(source.read_stored(i)), "fuzz"); }});
  }
}

void run_frame_log(Bytes bytes) {
  const FuzzFile file(bytes, ".partial");
  FrameLog log(file.path(), "fuzz");
  for (const std::int64_t index : log.indices()) (void)stored_frame_from(log.read(index), "fuzz");
}

}  // namespace knuckle::fuzz
