// SPDX-License-Identifier: Apache-2.0
#include "plot.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <ostream>

#include "gnuplot.hpp"

namespace egomod::fit {
namespace {

constexpr int kBins = 40;
constexpr int kCurvePoints = 400;
constexpr double kShownShare = 0.995;  // of the faster class; the rest would squeeze the picture

double shown_until_mps(const Labels& labels) {
  const auto quantile = [](const std::vector<double>& ascending) {
    const auto at = static_cast<std::size_t>(kShownShare * static_cast<double>(ascending.size()));
    return ascending[std::min(at, ascending.size() - 1)];
  };
  return std::max({quantile(labels.static_mps), quantile(labels.moving_mps), 1e-3});
}

void write_histogram(std::ostream& out, const char* name, const std::vector<double>& speeds_mps,
                     double until_mps) {
  std::array<int, kBins> counts{};
  for (const double speed : speeds_mps) {
    const auto bin = static_cast<std::size_t>(speed / until_mps * kBins);
    if (bin < counts.size()) ++counts[bin];
  }
  const double width = until_mps / kBins;
  out << "$" << name << " << EOD\n";
  for (int k = 0; k < kBins; ++k) {
    const double density =
        counts[static_cast<std::size_t>(k)] / (width * static_cast<double>(speeds_mps.size()));
    out << (k + 0.5) * width << ' ' << density << '\n';
  }
  out << "EOD\n";
}

void write_curves(std::ostream& out, const RayleighClassifier& c, double until_mps) {
  out << "$curves << EOD\n";
  for (int k = 0; k <= kCurvePoints; ++k) {
    const double x = until_mps * k / kCurvePoints;
    const double posterior = moving_posterior(c, x);
    out << x << ' ' << rayleigh_density(x, c.sigma_static_mps) << ' '
        << rayleigh_density(x, c.sigma_moving_mps) << ' ' << 1.0 - posterior << ' ' << posterior
        << '\n';
  }
  out << "EOD\n";
}

// As many digits as the thesis gives.
double rounded(double speed_mps) { return std::round(1e4 * speed_mps) * 1e-4; }

void write_threshold(std::ostream& out, const RayleighClassifier& c, double probability) {
  const auto threshold = speed_threshold(c, probability);
  if (!threshold) return;
  out << "set arrow from " << *threshold << ",0 to " << *threshold
      << ",1 nohead dashtype 2 lw 1.5\n"
      << "set label '" << 100 * probability << " %: " << rounded(*threshold) << " m/s' at "
      << *threshold << "," << probability << " offset 1,-0.7 front\n";
}

void write_script(std::ostream& out, const std::string& picture, const std::string& format,
                  const Labels& labels, const RayleighFit& fit) {
  const double until_mps = shown_until_mps(labels);
  out.precision(6);
  out << "# gnuplot rayleigh.gp\nset terminal "
      << (format == "svg" ? "svg size 900,900 background 'white'" : "pngcairo size 900,900")
      << "\nset output '" << picture << "'\n";
  write_histogram(out, "static_points", labels.static_mps, until_mps);
  write_histogram(out, "moving_points", labels.moving_mps, until_mps);
  write_curves(out, fit.classifier, until_mps);
  out << "set multiplot layout 2,1\nset xrange [0:" << until_mps << "]\n"
      << "set style fill transparent solid 0.35 noborder\nset xlabel 'speed [m/s]'\n"
      << "set title 'Likelihood of a point velocity given its class'\n"
      << "set ylabel 'probability density [s/m]'\n"
      << "plot $static_points with boxes lc rgb '#4477aa' title 'static, measured', "
      << "$moving_points with boxes lc rgb '#cc6633' title 'moving, measured', "
      << "$curves using 1:2 with lines lw 2 lc rgb '#224466' title 'static, sigma = "
      << rounded(fit.classifier.sigma_static_mps) << " m/s', "
      << "$curves using 1:3 with lines lw 2 lc rgb '#883311' title 'moving, sigma = "
      << rounded(fit.classifier.sigma_moving_mps) << " m/s'\n"
      << "set title 'Posterior of the class given the velocity'\nset ylabel 'probability'\n"
      << "set yrange [0:1.02]\nset key center right\n";
  write_threshold(out, fit.classifier, 0.5);
  write_threshold(out, fit.classifier, 0.99);
  out << "plot $curves using 1:4 with lines lw 2 lc rgb '#4477aa' title 'static', "
      << "$curves using 1:5 with lines lw 2 lc rgb '#cc6633' title 'moving'\n"
      << "unset multiplot\n";
}

}  // namespace

std::string draw_figure(const std::string& directory, const std::string& format,
                        const Labels& labels, const RayleighFit& fit) {
  const std::string picture = "rayleigh." + format;
  const std::string script = directory + "/rayleigh.gp";
  std::ofstream file(script);
  write_script(file, picture, format, labels, fit);
  file.close();
  if (!file) throw InputError(script + ": cannot be written");
  gnuplot::run(directory, "rayleigh.gp");
  return directory + "/" + picture;
}

}  // namespace egomod::fit
