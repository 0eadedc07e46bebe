// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/error.h"
#include "knuckle/core/option_faults.h"

namespace knuckle {
namespace {

class Checker final : public OptionVisitor {
 public:
  explicit Checker(std::string_view what) : what_(what) {}

  void real(std::string_view name, double& value, const Interval& range) override {
    require(name, range_fault(value, range));
  }
  void integer(std::string_view name, int& value, const Interval& range) override {
    require(name, range_fault(value, range));
  }
  void seed(std::string_view, std::uint64_t&) override {}
  void flag(std::string_view, bool&) override {}
  void text(std::string_view, std::string&) override {}
  void choice(std::string_view name, std::string& value, std::span<const std::string_view> known) override {
    require(name, choice_fault(value, known));
  }
  void reals(std::string_view name, std::vector<double>& value, const Interval& range, std::size_t shortest,
             std::size_t longest) override {
    require(name, list_fault(value, range, shortest, longest));
  }
  void texts(std::string_view name, std::vector<std::string>& value,
             std::span<const std::string_view> known) override {
    require(name, texts_fault(value, known));
  }

 private:
  void require(std::string_view name, const OptionFault& fault) const {
    if (fault) fail("{}: {} {}", what_, name, *fault);
  }

  std::string_view what_;
};

}  // namespace

void detail::check_visited(const std::function<void(OptionVisitor&)>& show_options, std::string_view what) {
  Checker checker(what);
  show_options(checker);
}

}  // namespace knuckle
