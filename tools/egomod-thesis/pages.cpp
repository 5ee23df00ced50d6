// SPDX-License-Identifier: Apache-2.0
#include "pages.hpp"

#include <fmt/format.h>

#include "html.hpp"

namespace egomod::thesis {
namespace {

constexpr const char* kTitle = "The thesis's experiment, reproduced";
constexpr const char* kIntroduction =
    "A. Abaabu, Independently Moving Objects Detection based on Stereo Visual Odometry (Instituto "
    "Superior Tecnico), section V: a target drives away at 0.4 m/s + 0.015 m/s^2 t, seen by a "
    "stereo rig of 0.375 m baseline and 800x600 pixels, at rest first, then following at 0.4 m/s. "
    "Here it happens in the built-in world (thesis-still, thesis-moving), and for the range in a "
    "variant of thesis-still whose target starts close to the rig and goes on to the far wall. The "
    "preset thesis takes one pair a second, as published, the default method all 30. Errors are "
    "those of the centroid of the visible surface.";

std::vector<eval::FigureTable> tables_of(const Reproduction& r) {
  return {comparison_table(r.cases, r.fits), threshold_table(r.fits), error_table(r.cases)};
}

}  // namespace

std::string html_of(const Reproduction& r) {
  std::string body = fmt::format("<h1>{}</h1>\n<p>{}</p>\n", kTitle, kIntroduction);
  for (const eval::FigureTable& table : tables_of(r)) body += eval::html_of(table) + "<br>\n";
  body += "<h2>Deviations</h2>\n";
  for (const Deviation& d : deviations(r.cases, r.fits)) {
    body += fmt::format("<section class=\"panel\"><h3>{}</h3><p>{}</p></section><br>\n",
                        eval::html_escaped(d.what), eval::html_escaped(d.why));
  }
  body += "<h2>Figures</h2>\n<div class=\"plots\">\n";
  for (const auto& [name, plot] : r.pictures.all()) body += eval::html_of(*plot);
  return eval::html_page(kTitle, body + "</div>\n");
}

std::string markdown_of(const Reproduction& r, const std::filesystem::path& pictures) {
  std::string text = fmt::format(
      "<!-- SPDX-License-Identifier: Apache-2.0 -->\n"
      "<!-- Made by tools/reproduce-thesis; what is changed here by hand is lost. -->\n"
      "# {}\n\nMade by `tools/reproduce-thesis`. {}\n\n",
      kTitle, kIntroduction);
  for (const eval::FigureTable& table : tables_of(r))
    text += fmt::format("## {}\n\n{}\n", table.title, eval::markdown_of(table));
  text += "## Deviations\n\n";
  for (const Deviation& d : deviations(r.cases, r.fits))
    text += fmt::format("**{}** {}\n\n", d.what, d.why);
  text += "## Figures\n";
  for (const auto& [name, plot] : r.pictures.all()) {
    text += fmt::format("\n{}\n\n![{}]({}.svg)\n", plot->caption, plot->caption,
                        (pictures / name).generic_string());
  }
  return text;
}

}  // namespace egomod::thesis
