// SPDX-License-Identifier: Apache-2.0
#include "figure.hpp"

#include <fstream>
#include <sstream>

#include "gnuplot.hpp"
#include "tables.hpp"
#include "temporary_folder.hpp"

namespace egomod::eval {
namespace {

std::string script_of(const std::vector<Figure>& figures) {
  std::string script;
  for (std::size_t i = 0; i < figures.size(); ++i) {
    script += fmt::format(
        "reset\nset terminal svg size {},{} dynamic noenhanced font 'Helvetica,13' background "
        "'white' name 'figure{}'\nset output '{}.svg'\n"
        "set border 3 lc rgb '#8c959f'\nset tics nomirror textcolor rgb '#57606a'\n"
        "set grid lc rgb '#e4e7eb' lt 1 lw 1\nset key top right textcolor rgb '#24292f'\n"
        "{}unset output\n",
        kFigureWidth_px, figures[i].height_px, i, i, figures[i].script);
  }
  return script;
}

}  // namespace

std::string quotable(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '\'') out += '\'';
    if (static_cast<unsigned char>(c) >= 0x20) out += c;
  }
  return out;
}

std::string svg_of(const std::string& file) {
  std::ifstream stream(file);
  std::stringstream text;
  text << stream.rdbuf();
  const std::string svg = text.str();
  const auto start = svg.find("<svg");
  if (!stream || start == std::string::npos)
    throw gnuplot::GnuplotError("gnuplot drew no figure into " + file);
  return svg.substr(start);
}

std::vector<Plot> draw(const std::vector<Figure>& figures) {
  const TemporaryFolder folder;
  std::ofstream script(folder.path() + "/figures.gp");
  script << script_of(figures);
  script.close();
  if (!script) throw InputError(folder.path() + "/figures.gp: cannot be written");
  gnuplot::run(folder.path(), "figures.gp");
  std::vector<Plot> plots;
  for (std::size_t i = 0; i < figures.size(); ++i)
    plots.push_back({figures[i].caption, svg_of(fmt::format("{}/{}.svg", folder.path(), i))});
  return plots;
}

}  // namespace egomod::eval
