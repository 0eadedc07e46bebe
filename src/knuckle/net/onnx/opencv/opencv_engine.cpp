// SPDX-License-Identifier: Apache-2.0
// All that knows OpenCV's networks: libknuckle_opencv_dnn.so.
#include <algorithm>
#include <stdexcept>
#include <utility>

#include <opencv2/core/utils/logger.hpp>
#include <opencv2/dnn.hpp>

#include "knuckle/net/onnx/onnx_engine_library.h"

namespace knuckle {
namespace {

/// The fault in one line: OpenCV's messages have several, with places in its sources.
std::string one_line(const cv::Exception& error) {
  std::string line;
  for (const char letter : error.err.empty() ? error.msg : error.err) {
    const bool is_blank = letter == '\n' || letter == '\t' || letter == ' ' || letter == '\r';
    if (!is_blank) {
      line += letter;
    } else if (!line.empty() && line.back() != ' ') {
      line += ' ';
    }
  }
  constexpr std::size_t kMostLetters = 300;
  if (line.size() > kMostLetters) line = line.substr(0, kMostLetters) + " ...";
  return line;
}

/// Calls `work`; what OpenCV throws becomes a std::runtime_error of one line, but for a lack of memory.
template <class Work>
auto translated(const Work& work) {
  try {
    return work();
  } catch (const cv::Exception& error) {
    throw std::runtime_error(one_line(error));
  } catch (const std::logic_error& error) {
    throw std::runtime_error(error.what());
  }
}

std::vector<int> sizes_of(const OnnxShape& shape) {
  return {shape.begin(), shape.end()};
}

class OpenCvEngine final : public OnnxEngine {
 public:
  OpenCvEngine(std::string_view bytes, const OnnxModel& model)
      : input_sizes_(sizes_of(model.inputs.front().shape)), outputs_(model.outputs) {
    for (const OnnxValue& output : outputs_) names_.emplace_back(output.name);
    translated([&] {
      network_ = cv::dnn::readNetFromONNX(bytes.data(), bytes.size());
      network_.setPreferableBackend(cv::dnn::DNN_BACKEND_OPENCV);
      network_.setPreferableTarget(cv::dnn::DNN_TARGET_CPU);
    });
  }

  std::vector<std::vector<float>> run(std::span<const float> input) override {
    return translated([&] {
      cv::Mat blob(input_sizes_, CV_32F);
      if (blob.total() != input.size()) throw std::runtime_error("an input of another size");
      std::copy(input.begin(), input.end(), blob.ptr<float>());
      network_.setInput(blob);
      std::vector<cv::Mat> answers;
      network_.forward(answers, names_);
      std::vector<std::vector<float>> results;
      for (std::size_t i = 0; i < outputs_.size(); ++i)
        results.push_back(numbers_of(answers.at(i), outputs_[i]));
      return results;
    });
  }

 private:
  static std::vector<float> numbers_of(const cv::Mat& answer, const OnnxValue& output) {
    if (answer.type() != CV_32F || !answer.isContinuous() ||
        answer.total() != static_cast<std::size_t>(count_of(output.shape))) {
      throw std::runtime_error("its output '" + output.name + "' has another shape than the file says");
    }
    const auto* const numbers = answer.ptr<float>();
    return {numbers, numbers + answer.total()};
  }

  std::vector<int> input_sizes_;
  std::vector<OnnxValue> outputs_;
  std::vector<cv::String> names_;
  cv::dnn::Net network_;
};

std::unique_ptr<OnnxEngine> create_opencv_engine(std::string_view bytes, const OnnxModel& model) {
  return std::make_unique<OpenCvEngine>(bytes, model);
}

const OnnxEngineMaker& opencv_maker() {
  static const OnnxEngineMaker maker = [] {
    // Each answer is computed by the thread that asks for it, and nothing but our own line reaches the user.
    cv::setNumThreads(1);
    cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
    return OnnxEngineMaker{"OpenCV " CV_VERSION, create_opencv_engine};
  }();
  return maker;
}

}  // namespace
}  // namespace knuckle

extern "C" [[gnu::visibility("default")]] const knuckle::OnnxEngineMaker* knuckle_onnx_engine_1() {
  return &knuckle::opencv_maker();
}
