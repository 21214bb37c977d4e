// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/filter_diagonalization.hpp"

#include "core/error.hpp"
#include "harmonic_inversion/synthesize.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

namespace twang {
namespace {

EvenSeries even(const Trace& trace) {
  const std::vector<double>& y = trace.channels[0].values;
  return {trace.time_s[1] - trace.time_s[0],
          Eigen::Map<const Eigen::VectorXd>(y.data(), static_cast<Eigen::Index>(y.size()))};
}

const std::vector<SinusoidTruth> kTwo = {{20.0, 3.0, 1.0, 0.4}, {44.0, 9.0, 0.2, -2.0}};

/// The strongest candidate within 1 Hz.
const PoleCandidate* near(const std::vector<PoleCandidate>& found, double frequency_hz) {
  for (const PoleCandidate& candidate : found) {
    if (std::abs(candidate.pole.frequency_hz - frequency_hz) < 1.0) return &candidate;
  }
  return nullptr;
}

TEST(FilterDiagonalization, FindsPolesAmplitudesAndSmallErrorsWithoutNoise) {
  SynthesisOptions options;
  const auto found = filter_diagonalize(even(synthesize_sinusoids(kTwo, options)), {10.0, 60.0});
  for (const SinusoidTruth& truth : kTwo) {
    const PoleCandidate* candidate = near(found, truth.frequency_hz);
    ASSERT_NE(candidate, nullptr) << truth.frequency_hz;
    // The basis holds far more functions than poles, so U(0) is cut at 1e-11 of its largest
    // singular value; a pole is good to about the root of that times the leakage.
    EXPECT_NEAR(candidate->pole.frequency_hz, truth.frequency_hz, 1e-6 * truth.frequency_hz);
    EXPECT_NEAR(candidate->pole.decay_per_s, truth.decay_per_s, 1e-5 * truth.decay_per_s);
    EXPECT_NEAR(candidate->amplitude, truth.amplitude, 1e-4 * truth.amplitude);
    EXPECT_LT(candidate->error, 1e-4);
  }
}

TEST(FilterDiagonalization, FindsAPoleOnTheSeamOfTwoWindows) {
  FilterDiagonalizationOptions windows;
  windows.max_basis = 12;
  SynthesisOptions options;
  const EvenSeries signal = even(synthesize_sinusoids({{30.0, 3.0, 1.0, 0.4}}, options));
  for (const double low : {9.0, 9.5, 10.0, 10.5, 11.0}) {
    const auto found = filter_diagonalize(signal, {low, 60.0 - low + 0.3}, windows);
    const PoleCandidate* candidate = near(found, 30.0);
    ASSERT_NE(candidate, nullptr) << low;
    EXPECT_NEAR(candidate->pole.frequency_hz, 30.0, 1e-4);
  }
}

TEST(FilterDiagonalization, ReportsOnlyPolesInsideTheBand) {
  SynthesisOptions options;
  options.noise_sigma = 0.05;
  for (const auto& candidate :
       filter_diagonalize(even(synthesize_sinusoids(kTwo, options)), {30.0, 50.0})) {
    EXPECT_GE(candidate.pole.frequency_hz, 30.0);
    EXPECT_LE(candidate.pole.frequency_hz, 50.0);
  }
}

TEST(FilterDiagonalization, RefusesABandBeyondNyquistAndBadOptions) {
  const EvenSeries signal = even(synthesize_sinusoids(kTwo));
  EXPECT_THROW(static_cast<void>(filter_diagonalize(signal, {10.0, 121.0})), InputError);
  EXPECT_THROW(static_cast<void>(filter_diagonalize(signal, {20.0, 10.0})), InputError);
  FilterDiagonalizationOptions options;
  EXPECT_NO_THROW(options.check());
  options.max_basis = 3;
  EXPECT_THROW(options.check(), InputError);
  options = {};
  options.rank_tolerance = 0.0;
  EXPECT_THROW(options.check(), InputError);
}

TEST(FilterDiagonalization, AgreesWithHarminvOnACleanSignal) {
  if (std::system("command -v harminv > /dev/null 2>&1") != 0) GTEST_SKIP() << "no harminv here";
  const Trace trace = synthesize_sinusoids(kTwo);
  const InversionResult own = invert_harmonics(trace, {"y"});
  ASSERT_EQ(own.modes.size(), 2U);
  const auto input = std::filesystem::temp_directory_path() / "twang_harminv_input.txt";
  {
    std::ofstream file(input);
    file.precision(17);
    for (const double y : trace.channels[0].values) file << y << "\n";
  }
  const std::string command =
      "harminv -t " + std::to_string(1.0) + " 0.04-0.25 < " + input.string();
  FILE* pipe = popen(command.c_str(), "r");
  ASSERT_NE(pipe, nullptr);
  std::string output;
  char buffer[256];
  while (fgets(buffer, sizeof buffer, pipe) != nullptr) output += buffer;
  EXPECT_EQ(pclose(pipe), 0);
  std::filesystem::remove(input);
  int matched = 0;
  std::istringstream lines(output);
  for (std::string line; std::getline(lines, line);) {
    double frequency = 0.0;
    double decay = 0.0;
    // "frequency, decay constant, Q, amplitude, phase, error", here per sample.
    if (std::sscanf(line.c_str(), "%lf, %lf", &frequency, &decay) != 2) continue;
    for (const DampedSinusoid& mode : own.modes) {
      if (std::abs(frequency * 240.0 - mode.frequency_hz) > 0.5) continue;
      ++matched;
      EXPECT_NEAR(frequency * 240.0, mode.frequency_hz, 1e-5 * mode.frequency_hz);  // six digits
      EXPECT_NEAR(decay * 240.0, mode.decay_per_s, 1e-4 * mode.decay_per_s);        // are printed
    }
  }
  EXPECT_EQ(matched, 2) << output;
}

}  // namespace
}  // namespace twang
