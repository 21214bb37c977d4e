// SPDX-License-Identifier: GPL-3.0-or-later
// From film to material, and again from the traces that were written on the way.
#include "calibrate/calibrate.hpp"
#include "calibrate/render_rig.hpp"
#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "core/trace_file.hpp"
#include "tests/support/expect_refusal.hpp"
#include "tests/support/sample_strip.hpp"
#include "tests/support/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

namespace twang {
namespace {

namespace fs = std::filesystem;

CalibrationOptions quick() {
  CalibrationOptions options;
  options.ladder.max_dofs = 20000;
  options.validate = false;
  return options;
}

void expect_same_answer(const Calibration& a, const Calibration& b) {
  EXPECT_EQ(a.material.frequency_hz, b.material.frequency_hz);
  EXPECT_EQ(a.material.decay_per_s, b.material.decay_per_s);
  EXPECT_EQ(a.material.youngs_modulus_identified_pa, b.material.youngs_modulus_identified_pa);
  EXPECT_EQ(a.material.damping_stiffness_b_s, b.material.damping_stiffness_b_s);
  EXPECT_EQ(a.material.uncertainty.repeats, b.material.uncertainty.repeats);
}

class Rerun : public testing::Test {
 protected:
  fs::path film(const std::string& name, double modulus_pa, unsigned seed) {
    RenderOptions options;
    options.element = ElementKind::Hex8;
    options.ladder.max_dofs = 6000;  // of the truth's limit mesh, which is not asked here
    options.amplitude = 0.6;
    options.film.width_px = 480;
    options.film.height_px = 270;
    options.film.duration_s = 0.6;
    options.film.seed = seed;
    const ElasticMaterial material = {modulus_pa, 0.45, 1180.0, 1.6e-4};
    (void)render_rig(
        test::sample_strip({.part = true, .clamp = true, .film = true, .observable = true}),
        material,
        folder / name,
        options);
    return folder / name;
  }
  fs::path save(const Trace& trace, const std::string& name) {
    write_trace_csv(folder / name, trace);
    return folder / name;
  }
  test::TemporaryFolder folder;
};

TEST_F(Rerun, FromTheTracesGivesWhatTheFilmsGave) {
  // two repeats whose moduli differ by two per cent
  const std::vector<fs::path> films = {film("a.mp4", 0.99e9, 1), film("b.mp4", 1.01e9, 2)};
  int told = 0;
  CalibrationOptions options = quick();
  options.on_tracked = [&](const fs::path& path, const TrackResult& result) {
    EXPECT_EQ(path, films[static_cast<std::size_t>(told)]);
    EXPECT_EQ(result.trace.num_samples(), 144U);
    ++told;
  };
  const Calibration from_films = calibrate_from_films(
      test::sample_strip({.part = true, .clamp = true, .film = true, .observable = true}),
      films,
      options);
  EXPECT_EQ(told, 2);
  // lambda goes with E: half the difference of the two, tracked with noise
  EXPECT_NEAR(from_films.material.uncertainty.repeats, 0.01, 0.001);

  const std::vector<fs::path> traces = {save(from_films.repeats[0].trace, "trace_1.csv"),
                                        save(from_films.repeats[1].trace, "trace_2.csv")};
  const Calibration rerun = calibrate_from_traces(
      test::sample_strip({.part = true, .clamp = true, .film = true, .observable = true}),
      traces,
      quick());
  expect_same_answer(from_films, rerun);
  EXPECT_EQ(from_films.material.frequency_sigma_hz, rerun.material.frequency_sigma_hz);
  EXPECT_EQ(from_films.material.damping_stiffness_b_sigma_s,
            rerun.material.damping_stiffness_b_sigma_s);

  // columns may go; without sigmas all samples count alike, and the answer moves by less than its
  // own
  std::vector<fs::path> bare;
  for (int i = 0; i < 2; ++i) {
    const Trace& trace = from_films.repeats[static_cast<std::size_t>(i)].trace;
    bare.push_back(
        save({trace.time_s, {*trace.find("observable_mm")}}, "bare_" + std::to_string(i) + ".csv"));
  }
  const Material& stated = from_films.material;
  const Material unstated =
      calibrate_from_traces(
          test::sample_strip({.part = true, .clamp = true, .film = true, .observable = true}),
          bare,
          quick())
          .material;
  EXPECT_NEAR(unstated.frequency_hz, stated.frequency_hz, stated.frequency_sigma_hz);
  EXPECT_NEAR(unstated.decay_per_s, stated.decay_per_s, stated.decay_sigma_per_s);
  EXPECT_NEAR(unstated.uncertainty.repeats, stated.uncertainty.repeats, 0.001);
}

TEST_F(Rerun, FromAnEditedTraceOrANarrowerWindowStaysClose) {
  const Calibration original = calibrate_from_films(
      test::sample_strip({.part = true, .clamp = true, .film = true, .observable = true}),
      {film("a.mp4", 1e9, 1)},
      quick());
  const Trace& trace = original.repeats[0].trace;
  const fs::path whole = save(trace, "trace.csv");

  Trace edited{{}, {{"observable_mm", {}}}};
  const std::vector<double>& observable = trace.find("observable_mm")->values;
  for (std::size_t n = 0; n < trace.num_samples(); ++n) {
    if (n % 11 == 5) continue;  // rows deleted
    edited.time_s.push_back(trace.time_s[n]);
    edited.channels[0].values.push_back(n % 17 == 3 ? kNaN : observable[n]);  // cells cleared
  }
  const Calibration rerun = calibrate_from_traces(
      test::sample_strip({.part = true, .clamp = true, .film = true, .observable = true}),
      {save(edited, "edited.csv")},
      quick());
  const Material& a = original.material;
  const Material& b = rerun.material;
  // a sixth of the samples less: the difference is part of either's sigma
  EXPECT_NEAR(a.frequency_hz, b.frequency_hz, 3.0 * b.frequency_sigma_hz);
  EXPECT_NEAR(a.decay_per_s, b.decay_per_s, 3.0 * b.decay_sigma_per_s);
  EXPECT_NE(a.frequency_hz, b.frequency_hz);

  CalibrationOptions narrow = quick();
  narrow.inversion.start_s = 0.15;
  narrow.inversion.end_s = 0.4;
  const Calibration window = calibrate_from_traces(
      test::sample_strip({.part = true, .clamp = true, .film = true, .observable = true}),
      {whole},
      narrow);
  EXPECT_NEAR(window.inversion.time_origin_s, 0.15, 1.0 / 240.0);
  EXPECT_LE(window.inversion.time_end_s, 0.4);
  EXPECT_NEAR(
      a.frequency_hz, window.material.frequency_hz, 3.0 * window.material.frequency_sigma_hz);
}

TEST_F(Rerun, RefusesRepeatsOfDifferentColumns) {
  Trace first{{}, {{"left.x_mm", {}}}};
  Trace second{{}, {{"right.x_mm", {}}}};
  for (int n = 0; n < 200; ++n) {
    const double t = n / 240.0;
    for (Trace* trace : {&first, &second}) {
      trace->time_s.push_back(t);
      trace->channels[0].values.push_back(std::exp(-8.0 * t) * std::cos(kTwoPi * 50.0 * t));
    }
  }
  Rig rig = test::sample_strip({.part = true, .clamp = true, .film = true, .observable = true});
  rig.observable.reset();
  EXPECT_TRUE(test::holds(
      test::refusal_of([&] {
        (void)calibrate_from_traces(rig, {save(first, "1.csv"), save(second, "2.csv")}, quick());
      }),
      "2.csv: offers other columns than"));
}

}  // namespace
}  // namespace twang
