// SPDX-License-Identifier: Apache-2.0
// Networks of other engines.
#include "fuzz_target.h"

#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "knuckle/net/onnx/onnx_check.h"
#include "knuckle/net/onnx/onnx_engine.h"
#include "knuckle/net/onnx/onnx_file.h"

namespace knuckle::fuzz {

/// What passes the check is written again to the same model, and the engine, where there is one, runs it or
/// says why not; it is to crash on nothing that the check lets pass.
void run_onnx(Bytes bytes) {
  constexpr OnnxLimits kSmall{.numbers = 1 << 18, .work = 1 << 22};
  const OnnxModel model = checked_onnx(parse_onnx(as_text(bytes), "fuzz.onnx"), "fuzz.onnx", kSmall);
  const std::string written = onnx_bytes(model);
  if (onnx_bytes(parse_onnx(written, "fuzz.onnx")) != written)
    throw std::logic_error("written otherwise than read");
  if (!onnx_support().is_there) return;
  const std::vector<float> input(static_cast<std::size_t>(count_of(model.inputs.front().shape)), 0.5f);
  const std::unique_ptr<OnnxEngine> engine = create_onnx_engine(model, "fuzz.onnx");
  try {
    (void)engine->run(input);
  } catch (const std::runtime_error& error) {
    if (std::string_view(error.what()).find('\n') != std::string_view::npos)
      throw std::logic_error("not one line");
  }
}

}  // namespace knuckle::fuzz
