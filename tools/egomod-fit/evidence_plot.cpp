// SPDX-License-Identifier: Apache-2.0
#include "evidence_plot.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <ostream>

#include "gnuplot.hpp"
#include "labels.hpp"

namespace egomod::fit {
namespace {

constexpr int kBars = 50;
constexpr double kLeastOnLogScale = 1e-2;

struct Panel {
  const char* title;
  const char* axis;
  const ClassValues& values;
  const FittedCut& cut;
  bool logarithmic;

  [[nodiscard]] double place(double value) const {
    return logarithmic ? std::log10(std::max(value, kLeastOnLogScale)) : value;
  }
};

struct Span {
  double from, to;
  [[nodiscard]] double width() const { return (to - from) / kBars; }
};

Span span_of(const Panel& panel) {
  Span span{panel.place(panel.cut.present), panel.place(panel.cut.present)};
  for (const std::vector<double>* values : {&panel.values.still, &panel.values.moving}) {
    if (values->empty()) continue;
    span.from = std::min(span.from, panel.place(values->front()));
    span.to = std::max(span.to, panel.place(values->back()));
  }
  return {span.from - 0.5, span.to + 0.5};
}

// Shares of the class, so that the rarer one shows as well.
void write_bars(std::ostream& out, const char* name, const Panel& panel,
                const std::vector<double>& values, const Span& span) {
  std::array<int, kBars> counts{};
  for (const double value : values) {
    const double bar = (panel.place(value) - span.from) / span.width();
    ++counts[static_cast<std::size_t>(std::clamp(bar, 0.0, kBars - 1.0))];
  }
  out << "$" << name << " << EOD\n";
  for (int k = 0; k < kBars; ++k) {
    out << span.from + (k + 0.5) * span.width() << ' '
        << counts[static_cast<std::size_t>(k)] / std::max(1.0, static_cast<double>(values.size()))
        << '\n';
  }
  out << "EOD\n";
}

void write_cut(std::ostream& out, const Panel& panel, const Span& span, double cut,
               const char* which, double height) {
  const double x = panel.place(cut);
  const bool is_left = x < 0.5 * (span.from + span.to);
  out << "set arrow from first " << x << ",graph 0 to first " << x << ",graph 1 nohead lw 1.5\n"
      << "set label '" << which << ": " << std::round(100.0 * cut) / 100.0 << "' at first " << x
      << ",graph " << height << (is_left ? " left offset 0.5,0" : " right offset -0.5,0")
      << " front boxed\n";
}

void write_panel(std::ostream& out, const Panel& panel) {
  const Span span = span_of(panel);
  write_bars(out, "still", panel, panel.values.still, span);
  write_bars(out, "moving", panel, panel.values.moving, span);
  out << "unset arrow\nunset label\nset title '" << panel.title << "'\nset xlabel '" << panel.axis
      << "'\nset xrange [" << span.from << ":" << span.to << "]\n";
  write_cut(out, panel, span, panel.cut.present, "in force", 0.95);
  if (panel.cut.best && *panel.cut.best != panel.cut.present)
    write_cut(out, panel, span, *panel.cut.best, "fitted", 0.87);
  out << "plot $still with boxes lc rgb '#4477aa' title 'static (" << panel.values.still.size()
      << ")', $moving with boxes lc rgb '#cc6633' title 'moving (" << panel.values.moving.size()
      << ")'\n";
}

void write_figure(std::ostream& out, const std::string& picture, const std::string& format,
                  const FilterSamples& samples, const FilterModel& model) {
  out.precision(6);
  out << "# gnuplot evidence.gp\nset terminal "
      << (format == "svg" ? "svg size 1200,900 background 'white'" : "pngcairo size 1200,900")
      << "\nset output '" << picture << "'\nset multiplot layout 2,2\n"
      << "set style fill transparent solid 0.45 noborder\nset style textbox opaque noborder\nset "
         "key above horizontal\n"
      << "set ylabel 'share of the class'\nset yrange [1e-4:2]\nset logscale y\n";
  write_panel(out, {"Points: evidence", "log likelihood ratio, moving over static",
                    samples.evidence, model.evidence, false});
  write_panel(out, {"Points: velocity against rest", "log_{10} chi2, 3 degrees of freedom",
                    samples.chi2, model.chi2, true});
  write_panel(out, {"Objects: most evidence in one pair (min\\_evidence)", "log_{10} evidence",
                    samples.pair_evidence, model.min_evidence, true});
  write_panel(out, {"Objects: most summed evidence (confirm\\_evidence)", "log_{10} evidence",
                    samples.summed_evidence, model.confirm_evidence, true});
  out << "unset multiplot\n";
}

}  // namespace

std::string draw_evidence(const std::string& directory, const std::string& format,
                          const FilterSamples& samples, const FilterModel& model) {
  const std::string picture = "evidence." + format;
  const std::string script = directory + "/evidence.gp";
  std::ofstream file(script);
  write_figure(file, picture, format, samples, model);
  file.close();
  if (!file) throw InputError(script + ": cannot be written");
  gnuplot::run(directory, "evidence.gp");
  return directory + "/" + picture;
}

}  // namespace egomod::fit
