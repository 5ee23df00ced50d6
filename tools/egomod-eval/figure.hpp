// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <string>
#include <vector>

namespace egomod::eval {

constexpr double kFigureWidth_px = 640.0;
constexpr double kFigureHeight_px = 400.0;

// A figure's part of a gnuplot script; its data lie in the script itself.
struct Figure {
  std::string caption;
  std::string script;
  double height_px = kFigureHeight_px;
};

// A named block of data, one row of numbers each time.
class FigureData {
 public:
  explicit FigureData(const std::string& name) : text_("$" + name + " << EOD\n") {}
  template <typename... Numbers>
  void row(Numbers... numbers) {
    ((text_ += fmt::format("{:.9g} ", numbers)), ...);
    text_ += '\n';
    empty_ = false;
  }
  void gap() { text_ += '\n'; }
  [[nodiscard]] bool empty() const { return empty_; }
  [[nodiscard]] std::string text() const { return text_ + "EOD\n"; }

 private:
  std::string text_;
  bool empty_ = true;
};

struct Plot {
  std::string caption;
  std::string svg;  // one <svg> element
};

// Between single quotes of gnuplot's.
[[nodiscard]] std::string quotable(const std::string& text);
// Throws gnuplot::GnuplotError.
[[nodiscard]] std::vector<Plot> draw(const std::vector<Figure>& figures);
// The element of an SVG file, without the lines before it, which only a file of its own may have.
// Throws gnuplot::GnuplotError where there is none.
[[nodiscard]] std::string svg_of(const std::string& file);

}  // namespace egomod::eval
