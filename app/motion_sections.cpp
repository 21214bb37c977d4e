// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/motion_sections.hpp"

#include "core/constants.hpp"
#include "core/text.hpp"
#include "harmonic_inversion/decay_checks.hpp"
#include "report/material_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace twang::app {
namespace {

/// f or d of the windows against their amplitude.
Chart amplitude_chart(const Repeat& repeat,
                      const char* y_label,
                      double AmplitudeWindow::*value,
                      double AmplitudeWindow::*sigma) {
  Chart chart;
  chart.x_label =
      "amplitude, " + (repeat.columns.size() == 1 ? repeat.columns.front() : "all columns");
  chart.y_label = y_label;
  chart.log_x = true;
  ChartSeries windows{"windows, with one sigma", {}, {}, ChartSeries::Style::Points};
  for (const AmplitudeWindow& window : repeat.inversion.amplitude_windows) {
    windows.x.push_back(window.amplitude);
    windows.y.push_back(window.*value);
    windows.y_sigma.push_back(window.*sigma);
  }
  ChartSeries fit{"all of it", {}, {}, ChartSeries::Style::Dashed};
  const DampedSinusoid& mode = repeat.inversion.modes.front();
  const bool is_frequency = value == &AmplitudeWindow::frequency_hz;
  const auto [least, most] = std::minmax_element(windows.x.begin(), windows.x.end());
  fit.x = {*least, *most};
  fit.y.assign(2, is_frequency ? mode.frequency_hz : mode.decay_per_s);
  chart.series = {std::move(windows), std::move(fit)};
  return chart;
}

/// The sentence of the inversion on f and d against amplitude; empty if it says nothing.
std::string amplitude_sentence(const InversionResult& inversion) {
  constexpr const char* kSays = "between amplitudes of";
  for (const std::string& note : inversion.notes) {
    if (note.find(kSays) != std::string::npos) return note;
  }
  return {};
}

/// How the strongest sinusoid changes while it decays, if it was looked at in windows.
std::optional<ReportSection> amplitude_section(const Repeat& repeat) {
  const InversionResult& inversion = repeat.inversion;
  if (inversion.amplitude_windows.size() < 2) return std::nullopt;
  ReportSection section;
  section.title = "Frequency and decay against amplitude";
  section.paragraphs.push_back(
      fmt::format("The strongest sinusoid fitted anew in {} windows, while its amplitude falls.",
                  inversion.amplitude_windows.size()));
  const std::string sentence = amplitude_sentence(inversion);
  if (!sentence.empty()) section.paragraphs.push_back(sentence);
  section.charts.push_back(amplitude_chart(repeat,
                                           "frequency [Hz]",
                                           &AmplitudeWindow::frequency_hz,
                                           &AmplitudeWindow::frequency_sigma_hz));
  section.charts.push_back(amplitude_chart(
      repeat, "decay d [1/s]", &AmplitudeWindow::decay_per_s, &AmplitudeWindow::decay_sigma_per_s));
  return section;
}

/// The fit's f and d beside those of the cross-checks.
TextTable checks_table(const InversionResult& inversion) {
  const DampedSinusoid& mode = inversion.modes.front();
  TextTable table;
  table.head = {"strongest sinusoid by", "f [Hz]", "d [1/s]", "points", ""};
  table.rows.push_back({"the fit",
                        text_with_sigma(mode.frequency_hz, mode.frequency_sigma_hz),
                        text_with_sigma(mode.decay_per_s, mode.decay_sigma_per_s),
                        std::to_string(inversion.num_samples),
                        ""});
  for (const DecayCheck& check : inversion.decay_checks) {
    if (!check.usable()) {
      table.rows.push_back({check.method, "–", "–", "", check.message});
      continue;
    }
    table.rows.push_back({check.method,
                          text_with_sigma(check.frequency_hz, check.frequency_sigma_hz),
                          text_with_sigma(check.decay_per_s, check.decay_sigma_per_s),
                          std::to_string(check.num_points),
                          disagreement(check, mode).empty() ? "agrees" : "disagrees"});
  }
  return table;
}

ReportSection trace_section(const Repeat& repeat) {
  const InversionResult& inversion = repeat.inversion;
  const Channel& channel = *repeat.trace.find(repeat.columns.front());
  ReportSection section;
  section.title = "The trace and its fit";
  section.paragraphs.push_back(fmt::format(
      "Found by {}. Used from {} s to {} s, {} samples; the residual lies {} dB below the "
      "strongest sinusoid.",
      inversion.method,
      rounded_text(inversion.time_origin_s, 5),
      rounded_text(inversion.time_end_s, 5),
      inversion.num_samples,
      rounded_text(inversion.snr_db, 3)));
  Chart chart;
  chart.x_label = "time [s]";
  chart.y_label = channel.name;
  chart.series.push_back(
      {"tracked", repeat.trace.time_s, channel.values, ChartSeries::Style::Points});
  ChartSeries fit{"fit", {}, {}, ChartSeries::Style::Line};
  Chart residual;
  residual.x_label = "time [s]";
  residual.y_label = "tracked - fit, " + channel.name;
  ChartSeries rest{"residual", {}, {}, ChartSeries::Style::Points};
  constexpr int kPointsPerPeriod = 24;
  const double step_s = 1.0 / (inversion.modes.front().frequency_hz * kPointsPerPeriod);
  for (double t = inversion.time_origin_s; t <= inversion.time_end_s; t += step_s) {
    fit.x.push_back(t);
    fit.y.push_back(inversion.evaluate(0, t));
  }
  const Channel* offset_s = repeat.trace.time_offset_of(channel.name);
  for (std::size_t i = 0; i < repeat.trace.num_samples(); ++i) {
    const double t = repeat.trace.time_s[i] + (offset_s == nullptr ? 0.0 : offset_s->values[i]);
    if (!std::isfinite(t)) continue;
    if (t < inversion.time_origin_s || t > inversion.time_end_s) continue;
    rest.x.push_back(t);
    rest.y.push_back(channel.values[i] - inversion.evaluate(0, t));
  }
  chart.series.push_back(std::move(fit));
  chart.marks.push_back({inversion.time_origin_s, "start"});
  residual.series.push_back(std::move(rest));
  section.charts = {std::move(chart), std::move(residual)};
  return section;
}

/// The spectrum of the fit, as far down as that of the trace reaches.
ChartSeries fit_spectrum(const Repeat& repeat) {
  const std::vector<double>& trace = repeat.spectrum.amplitude;
  const double floor = *std::min_element(trace.begin(), trace.end());
  ChartSeries series{"spectrum of the fit",
                     repeat.model_spectrum.frequency_hz,
                     repeat.model_spectrum.amplitude,
                     ChartSeries::Style::Dashed};
  for (double& amplitude : series.y) {
    if (amplitude < floor) amplitude = kNaN;
  }
  return series;
}

ReportSection spectrum_section(const Repeat& repeat) {
  ReportSection section;
  section.title = "The spectrum and the sinusoids found";
  Chart chart;
  chart.x_label = "frequency [Hz]";
  chart.y_label = "amplitude, " + repeat.columns.front();
  chart.log_y = true;
  chart.series.push_back({"spectrum",
                          repeat.spectrum.frequency_hz,
                          repeat.spectrum.amplitude,
                          ChartSeries::Style::Line});
  chart.series.push_back(fit_spectrum(repeat));
  TextTable table;
  table.head = {"f [Hz]", "sigma [Hz]", "d [1/s]", "sigma [1/s]", "damping ratio [-]", "amplitude"};
  for (const DampedSinusoid& mode : repeat.inversion.modes) {
    chart.marks.push_back({mode.frequency_hz, rounded_text(mode.frequency_hz, 4) + " Hz"});
    table.rows.push_back({rounded_text(mode.frequency_hz, 6),
                          rounded_text(mode.frequency_sigma_hz, 2),
                          rounded_text(mode.decay_per_s, 5),
                          rounded_text(mode.decay_sigma_per_s, 2),
                          rounded_text(mode.damping_ratio(), 4),
                          rounded_text(mode.channels.front().amplitude, 4)});
  }
  section.charts.push_back(std::move(chart));
  section.tables.push_back(std::move(table));
  if (!repeat.inversion.decay_checks.empty()) {
    section.paragraphs.push_back(
        "The decay of the strongest sinusoid was checked on the same samples by two other methods: "
        "the heights of successive extrema, and the ridge of a wavelet transform.");
    section.tables.push_back(checks_table(repeat.inversion));
  }
  if (!repeat.inversion.rejected.empty()) {
    TextTable rejected;
    rejected.head = {"rejected f [Hz]", "d [1/s]", "because"};
    for (const RejectedMode& mode : repeat.inversion.rejected) {
      rejected.rows.push_back(
          {rounded_text(mode.frequency_hz, 5), rounded_text(mode.decay_per_s, 4), mode.reason});
    }
    section.tables.push_back(std::move(rejected));
  }
  return section;
}

}  // namespace

std::vector<ReportSection> motion_sections(const Repeat& repeat) {
  std::vector<ReportSection> sections = {trace_section(repeat), spectrum_section(repeat)};
  if (auto section = amplitude_section(repeat)) sections.push_back(std::move(*section));
  return sections;
}

}  // namespace twang::app
