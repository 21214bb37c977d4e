// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/report_page.hpp"

#include "app/motion_sections.hpp"
#include "capture/png.hpp"
#include "coarsen/follow_mode.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "report/material_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace twang::app {
namespace {

std::string percent(double relative) { return rounded_text(100.0 * relative, 2) + " %"; }

std::string with_sigma(double value, double sigma, const char* unit) {
  return text_with_sigma(value, sigma) + " " + unit;
}

/// "1.71 ± 0.27 GPa", "263.8 kPa" without a sigma: a modulus in the unit in which it is easily
/// read.
std::string modulus_text(double pa, double sigma_pa = kNaN) {
  struct Unit {
    double pa;
    const char* name;
  };
  Unit easy{1.0, "Pa"};
  for (const Unit unit : {Unit{1e3, "kPa"}, Unit{1e6, "MPa"}, Unit{1e9, "GPa"}}) {
    if (pa >= unit.pa) easy = unit;
  }
  const std::string number = std::isfinite(sigma_pa)
                                 ? text_with_sigma(pa / easy.pa, sigma_pa / easy.pa)
                                 : rounded_text(pa / easy.pa, 4);
  return number + " " + easy.name;
}

ReportSection film_section(const Repeat& repeat) {
  const TrackResult& film = *repeat.film;
  ReportSection section;
  section.title = "The film: " + repeat.file.filename().string();
  const TimeBaseSummary& time = film.time_base;
  section.paragraphs.push_back(
      fmt::format("{} frames at {} frames/s (from the {}), {} doubled, {} missing; {} mm a pixel.",
                  time.frames,
                  rounded_text(time.capture_fps, 6),
                  time.source,
                  time.doubled,
                  time.gaps,
                  rounded_text(film.mm_per_px, 4)));
  section.picture_png = encode_png(film.first_frame_with_tracks);
  section.picture_caption = "The first frame with the markers found and the paths they take.";
  TextTable table;
  table.head = {"marker", "frames seen", "mean sigma [px]", "frames lost", "because"};
  for (const MarkerTrack& track : film.tracks) {
    double sum = 0.0;
    int seen = 0;
    for (const double sigma : track.sigma_px) {
      if (!std::isfinite(sigma)) continue;
      sum += sigma;
      ++seen;
    }
    table.rows.push_back({track.id,
                          std::to_string(seen),
                          rounded_text(seen ? sum / seen : kNaN, 2),
                          std::to_string(track.frames_lost),
                          track.lost_because});
  }
  section.tables.push_back(std::move(table));
  return section;
}

ReportSection ladder_section(const Calibration& calibration) {
  const MeshLadder& ladder = calibration.ladder;
  const double modulus = calibration.material.youngs_modulus_identified_pa;
  ReportSection section;
  section.title = "The ladder of meshes";
  section.paragraphs.push_back(ladder.choice);
  Chart chart;
  chart.x_label = "dx [mm]";
  const int mode = calibration.mode.mode;  // of the finest reference mesh
  chart.y_label = fmt::format("frequency of eigenmode {} at the identified E [Hz]", mode + 1);
  ChartSeries reference{"reference", {}, {}, ChartSeries::Style::Points};
  ChartSeries coarse{"coarse candidates", {}, {}, ChartSeries::Style::Points};
  ChartSeries limit{"limit", {}, {}, ChartSeries::Style::Dashed};
  TextTable table;
  table.head = {"element",
                "dx [mm]",
                "elements",
                fmt::format("f{} at E [Hz]", mode + 1),
                "mode distance [%]",
                "Hausdorff [%]",
                "f error, 10 modes [%]",
                "after rescale [%]",
                ""};
  double largest_dx_mm = 0.0;
  for (const MeshRung& rung : ladder.reference) {
    const double dx_mm = rung.mesh.requested_dx_m * kMillimetresPerMetre;
    const int here = follow_mode(ladder.reference.back(), mode, rung).mode;
    const double f = rung.modes.natural_frequency_hz(here) * std::sqrt(modulus);
    reference.x.push_back(dx_mm);
    reference.y.push_back(f);
    largest_dx_mm = std::max(largest_dx_mm, dx_mm);
    table.rows.push_back({std::string(to_string(rung.mesh.kind)) + " (reference)",
                          rounded_text(dx_mm, 4),
                          std::to_string(rung.mesh.num_elements()),
                          rounded_text(f, 6),
                          "",
                          "",
                          "",
                          "",
                          ""});
  }
  for (const CoarseCandidate& candidate : ladder.candidates) {
    const double dx_mm = candidate.dx_m * kMillimetresPerMetre;
    const double f =
        candidate
            .natural_frequency_hz[candidate.mode_of_reference[static_cast<std::size_t>(mode)]] *
        std::sqrt(modulus);
    coarse.x.push_back(dx_mm);
    coarse.y.push_back(f);
    largest_dx_mm = std::max(largest_dx_mm, dx_mm);
    const bool chosen = candidate.dx_m == ladder.coarse.mesh.requested_dx_m;
    table.rows.push_back({std::string(to_string(candidate.element)),
                          rounded_text(dx_mm, 4),
                          std::to_string(candidate.num_elements),
                          rounded_text(f, 6),
                          rounded_text(100.0 * candidate.comparison.max_difference, 3),
                          rounded_text(100.0 * candidate.comparison.hausdorff, 3),
                          rounded_text(100.0 * candidate.mean_frequency_error_before, 3),
                          rounded_text(100.0 * candidate.mean_frequency_error_after, 3),
                          chosen ? "chosen" : ""});
  }
  const double limit_hz = std::sqrt(calibration.limit.lambda_per_s2 * modulus) / kTwoPi;
  limit.x = {0.0, largest_dx_mm};
  limit.y = {limit_hz, limit_hz};
  for (ChartSeries* series : {&reference, &coarse}) {
    if (series->x.size() > 1 && series->x.front() > series->x.back()) {
      std::reverse(series->x.begin(), series->x.end());
      std::reverse(series->y.begin(), series->y.end());
    }
  }
  chart.series = {std::move(reference), std::move(coarse), std::move(limit)};
  section.charts.push_back(std::move(chart));
  section.tables.push_back(std::move(table));
  return section;
}

ReportSection mode_section(const Calibration& calibration) {
  ReportSection section;
  section.title = "Which eigenmode it is";
  section.paragraphs.push_back(calibration.mode.reason);
  if (!calibration.mode.doubt.empty()) section.paragraphs.push_back(calibration.mode.doubt);
  section.paragraphs.push_back(
      "Modes that what was inverted shows, by the modulus that would follow. Share: how much of it "
      "a mode moves at equal energy. Motion: correlation of the markers' motion with the mode's "
      "shape. Score: natural logarithm of the odds, frequency ratios, motion and share together.");
  TextTable table;
  table.head = {"eigenmode", "E", "share [%]", "motion", "ratios explained", "score", ""};
  for (const ModeCandidate& candidate : calibration.mode.candidates) {
    table.rows.push_back(
        {std::to_string(candidate.mode + 1),
         modulus_text(candidate.modulus_pa),
         rounded_text(100.0 * candidate.share, 3),
         std::isfinite(candidate.motion) ? rounded_text(candidate.motion, 3) : "–",
         fmt::format("{} of {}", candidate.explained, calibration.inversion.modes.size() - 1),
         rounded_text(candidate.score(), 3),
         candidate.mode == calibration.mode.mode ? "taken" : ""});
  }
  section.tables.push_back(std::move(table));
  return section;
}

ReportSection validation_section(const Validation& validation, bool rigs_own) {
  ReportSection section;
  section.title = "Simulated over tracked";
  section.paragraphs.push_back(fmt::format(
      "The coarse mesh with the numerical modulus and b, let go from the tracked start: rms "
      "difference {} of the initial "
      "amplitude, frequency {}, decay {}. {} steps of {} s in {} s. No time shift is fitted.",
      percent(validation.figures.rms_rel),
      percent(validation.figures.frequency_error_rel),
      percent(validation.figures.decay_error_rel),
      validation.run.steps,
      rounded_text(validation.step_s, 3),
      rounded_text(validation.run.wall_s, 3)));
  if (!rigs_own) {
    section.paragraphs.push_back(
        "The rig file has no observable, so the point of the mesh that moves most in its first "
        "mode stands for the tracked one.");
  }
  Chart chart;
  chart.x_label = "time [s]";
  chart.y_label = "observable [" + validation.unit + "], offset removed";
  chart.series.push_back(
      {"tracked", validation.time_s, validation.tracked, ChartSeries::Style::Points});
  chart.series.push_back(
      {"simulated", validation.fine_time_s, validation.fine_simulated, ChartSeries::Style::Line});
  section.charts.push_back(std::move(chart));
  return section;
}

ReportSection refinement_section(const Refinement& change, const std::string& unit) {
  ReportSection section;
  section.title = "Refined by the nonlinear simulation";
  section.paragraphs.push_back(fmt::format(
      "The linear estimate takes the motion for a sum of damped sinusoids, which a large one is "
      "not. E_n and b were fitted anew so that the coarse mesh, let go at up to {} {} and "
      "simulated "
      "with large deflections, follows {} samples of the first {} periods; amplitude, phase and "
      "offset were fitted beside them. {} simulations. E goes with E_n.",
      rounded_text(change.amplitude, 3),
      unit,
      change.samples,
      rounded_text(change.periods, 3),
      change.simulations));
  TextTable table;
  table.head = {"quantity", "linear", "change", "one sigma"};
  table.rows = {{"E_n",
                 modulus_text(change.linear_youngs_modulus_numerical_pa),
                 percent(change.modulus_change_rel),
                 percent(change.modulus_sigma_rel)},
                {"b",
                 rounded_text(change.linear_damping_stiffness_b_s * 1e3, 4) + " ms",
                 percent(change.damping_change_rel),
                 percent(change.damping_sigma_rel)},
                {"rms difference over the amplitude",
                 percent(change.linear_residual_rel),
                 "now " + percent(change.residual_rel),
                 ""}};
  section.tables.push_back(std::move(table));
  return section;
}

ReportSection numbers_section(const Calibration& calibration) {
  const Material& material = calibration.material;
  const UncertaintyBudget& budget = material.uncertainty;
  ReportSection section;
  section.title = "The numbers and their uncertainty";
  section.paragraphs.push_back(
      fmt::format("b was measured at {} Hz and holds near it; real prints change with frequency "
                  "and amplitude. The amplitude used ran "
                  "from {} to {} {}.",
                  rounded_text(material.frequency_hz, 4),
                  rounded_text(material.amplitude_range[1], 3),
                  rounded_text(material.amplitude_range[0], 3),
                  material.amplitude_unit));
  TextTable table;
  table.head = {"part of the budget of E", "one sigma"};
  table.rows = {{"statistical (f and d of the fit)", percent(budget.statistical)},
                {"between repeats", percent(budget.repeats)},
                {"mesh (Richardson limit)", percent(budget.mesh)},
                {"clock of the camera", percent(budget.clock)},
                {"printed dimensions", percent(budget.dimension)},
                {"density", percent(budget.density)},
                {"Poisson's ratio", percent(budget.poissons_ratio)},
                {"together (root sum of squares)", percent(budget.total())}};
  section.tables.push_back(std::move(table));
  TextTable provenance;
  provenance.head = {"made from", "SHA-256"};
  for (const ProvenanceInput& input : material.provenance.inputs)
    provenance.rows.push_back({input.file, input.sha256});
  section.tables.push_back(std::move(provenance));
  if (!material.specimen.empty()) {
    TextTable specimen;
    specimen.head = {"specimen", ""};
    for (const auto& [key, value] : material.specimen) specimen.rows.push_back({key, value});
    section.tables.push_back(std::move(specimen));
  }
  return section;
}

TextTable key_figures(const Material& material) {
  TextTable table;
  table.head = {"quantity", "value", "meaning"};
  table.rows = {
      {"E, identified",
       modulus_text(material.youngs_modulus_identified_pa,
                    material.youngs_modulus_identified_sigma_pa),
       "Young's modulus of the limit mesh: the material's own"},
      {"E_n, numerical",
       modulus_text(material.youngs_modulus_numerical_pa),
       fmt::format("for {} elements {} of {} mm, and for these alone",
                   material.numerical_elements,
                   material.numerical_element,
                   rounded_text(material.numerical_dx_mm, 4))},
      {"b",
       with_sigma(
           material.damping_stiffness_b_s * 1e3, material.damping_stiffness_b_sigma_s * 1e3, "ms"),
       "stiffness-proportional Rayleigh damping"},
      {"f",
       with_sigma(material.frequency_hz, material.frequency_sigma_hz, "Hz"),
       "frequency of the damped motion"},
      {"d",
       with_sigma(material.decay_per_s, material.decay_sigma_per_s, "1/s"),
       "decay, exp(-d t)"},
      {"tan delta", rounded_text(material.tan_delta, 4), "loss factor at f"},
      {"eigenmode", std::to_string(material.eigenmode), "of the part, that f was taken for"}};
  if (material.reported_youngs_modulus_pa) {
    const double reported = *material.reported_youngs_modulus_pa;
    table.rows.push_back(
        {"E, reported",
         modulus_text(reported),
         fmt::format("identified minus reported: {}",
                     percent(material.youngs_modulus_identified_pa / reported - 1.0))});
  }
  return table;
}

}  // namespace

ReportContent report_page(const Rig& rig, const Calibration& calibration) {
  const Material& material = calibration.material;
  ReportContent content;
  content.title = rig.name;
  content.headline = fmt::format("{}: E = {}, b = {} s at {} Hz",
                                 material.material,
                                 modulus_text(material.youngs_modulus_identified_pa,
                                              material.youngs_modulus_identified_sigma_pa),
                                 rounded_text(material.damping_stiffness_b_s, 4),
                                 rounded_text(material.frequency_hz, 4));
  content.key_figures = key_figures(material);
  content.warnings = calibration.warnings;
  content.remarks = calibration.remarks;
  for (const Repeat& repeat : calibration.repeats) {
    if (repeat.film) content.sections.push_back(film_section(repeat));
    for (ReportSection& section : motion_sections(repeat))
      content.sections.push_back(std::move(section));
  }
  content.sections.push_back(mode_section(calibration));
  content.sections.push_back(ladder_section(calibration));
  if (material.refinement) {
    content.sections.push_back(refinement_section(*material.refinement, material.amplitude_unit));
  }
  if (calibration.validation && calibration.validation->run.usable()) {
    content.sections.push_back(
        validation_section(*calibration.validation, rig.observable.has_value()));
  }
  content.sections.push_back(numbers_section(calibration));
  return content;
}

}  // namespace twang::app
