// SPDX-License-Identifier: Apache-2.0
#include "html.hpp"

#include <fmt/format.h>

#include "gnuplot.hpp"
#include "plots.hpp"

namespace egomod::eval {
namespace {

constexpr const char* kStyle = R"(
:root { color-scheme: light; --ink: #1f2328; --soft: #57606a; --line: #d8dee4; --accent: #1f6feb; }
* { box-sizing: border-box; }
body { margin: 0; background: #f6f8fa; color: var(--ink);
  font: 15px/1.5 system-ui, -apple-system, "Segoe UI", "DejaVu Sans", sans-serif; }
main { max-width: 1240px; margin: 0 auto; padding: 28px 24px 60px; }
h1 { font-size: 26px; margin: 0 0 4px; }
h2 { font-size: 21px; margin: 44px 0 2px; }
h3 { font-size: 15px; margin: 0 0 8px; }
.source { color: var(--soft); margin: 0 0 16px; overflow-wrap: anywhere; }
.panel { background: #fff; border: 1px solid var(--line); border-radius: 10px; padding: 14px 16px;
  overflow-x: auto; }
.cards { display: grid; grid-template-columns: repeat(auto-fit, minmax(150px, 1fr)); gap: 12px;
  margin: 0 0 16px; }
.card { background: #fff; border: 1px solid var(--line); border-top: 3px solid var(--accent);
  border-radius: 10px; padding: 10px 14px; }
.card b { display: block; font-size: 24px; line-height: 1.25; font-variant-numeric: tabular-nums; }
.card span { color: var(--soft); font-size: 13px; }
.plots { display: grid; grid-template-columns: repeat(auto-fit, minmax(480px, 1fr)); gap: 16px;
  margin-bottom: 16px; }
.plots svg { display: block; width: 100%; height: auto; }
.tables { columns: 2 480px; column-gap: 16px; }
.tables .panel { break-inside: avoid; margin-bottom: 16px; }
.wide { margin-bottom: 16px; }
table { border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums; font-size: 14px; }
th { text-align: right; font-weight: 600; color: var(--soft); border-bottom: 1px solid var(--line);
  padding: 3px 8px; vertical-align: bottom; }
td { text-align: right; padding: 3px 8px; border-bottom: 1px solid #f0f2f4; white-space: nowrap; }
tr:last-child td { border-bottom: 0; }
th:first-child, td:first-child { text-align: left; padding-left: 0; white-space: pre; }
.note { background: #fff8e5; border: 1px solid #eed9a0; border-radius: 10px; padding: 8px 14px;
  margin: 0 0 10px; }
@media print { body { background: #fff; } .panel, .card { break-inside: avoid; } }
)";

constexpr std::size_t kNarrowTable = 7;  // columns; more take the whole width

std::string row_of(const std::vector<std::string>& cells, const char* tag) {
  std::string row = "<tr>";
  for (const std::string& cell : cells)
    row += fmt::format("<{0}>{1}</{0}>", tag, html_escaped(cell));
  return row + "</tr>\n";
}

std::string card(const std::string& value, const char* name) {
  return value == "-"
             ? ""
             : fmt::format("<div class=\"card\"><b>{}</b><span>{}</span></div>\n", value, name);
}

std::string cards_of(const Evaluation& e) {
  std::string html = "<div class=\"cards\">\n";
  if (e.odometry && e.odometry->scored) {
    const OdometryFigures& o = *e.odometry;
    if (o.drift) html += card(number(o.drift->translation_percent, 2) + " %", "translation drift");
    html += card(number(1e3 * o.first_aligned_rmse_m, 1) + " mm", "rms position error");
    if (o.pair_mm) html += card(number(o.pair_mm->median, 2) + " mm", "median error a pair");
  }
  if (e.detection) {
    const DetectionFigures& d = *e.detection;
    html += card(number(d.f1, 3), "F1");
    html += card(number(d.precision, 3), "precision");
    html += card(number(d.recall, 3), "recall");
    html += card(number(d.false_per_minute, 2), "false objects a minute");
    if (d.velocity_mps)
      html += card(number(d.velocity_mps->rmse, 3) + " m/s", "rms velocity error");
    if (d.delay_s) html += card(number(d.delay_s->mean, 2) + " s", "until first detection");
  }
  return html + "</div>\n";
}

std::string note(const std::string& text) {
  return fmt::format("<p class=\"note\">{}</p>\n", html_escaped(text));
}

std::string tables_of(const Evaluation& e) {
  std::string narrow;
  std::string wide;
  for (const FigureTable& table : figure_tables(e))
    (table.header.size() > kNarrowTable ? wide : narrow) += html_of(table);
  return wide + "<div class=\"tables\">\n" + narrow + "</div>\n";
}

std::string section(const Evaluation& e, std::string& warning) {
  std::string html = fmt::format("<h2>{}</h2>\n<p class=\"source\">{}</p>\n", html_escaped(e.name),
                                 html_escaped(e.source));
  html += cards_of(e);
  for (const std::string& text : e.notes) html += note(text);
  try {
    std::string plots;
    for (const Plot& plot : draw_plots(e)) plots += html_of(plot);
    html += "<div class=\"plots\">\n" + plots + "</div>\n";
  } catch (const gnuplot::GnuplotError& error) {
    warning = error.what();
  }
  return html + tables_of(e);
}

}  // namespace

std::string html_escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '<') {
      out += "&lt;";
    } else if (c == '>') {
      out += "&gt;";
    } else if (c == '&') {
      out += "&amp;";
    } else {
      out += c;
    }
  }
  return out;
}

std::string html_of(const FigureTable& table) {
  std::string html =
      fmt::format("<section class=\"panel{}\"><h3>{}</h3><table>\n",
                  table.header.size() > kNarrowTable ? " wide" : "", html_escaped(table.title));
  if (table.header.size() > 2) html += row_of(table.header, "th");
  for (const auto& row : table.rows) html += row_of(row, "td");
  return html + "</table></section>\n";
}

std::string html_of(const Plot& plot) {
  return fmt::format("<section class=\"panel\"><h3>{}</h3>{}</section>\n",
                     html_escaped(plot.caption), plot.svg);
}

std::string html_page(const std::string& title, const std::string& body) {
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n"
      "<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<title>{}</title>\n<style>{}</style>\n</head>\n<body>\n<main>\n{}</main>\n"
      "</body>\n</html>\n",
      html_escaped(title), kStyle, body);
}

HtmlReport html_report(const std::vector<Evaluation>& evaluations) {
  HtmlReport report;
  std::string body;
  for (const Evaluation& e : evaluations) body += section(e, report.warning);
  std::string head = "<h1>egomod evaluation</h1>\n";
  if (!report.warning.empty()) head += note(report.warning);
  if (evaluations.size() > 1) head += html_of(overview(evaluations));
  report.text = html_page("egomod evaluation", head + body);
  return report;
}

}  // namespace egomod::eval
