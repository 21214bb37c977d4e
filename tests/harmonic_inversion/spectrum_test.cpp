// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/spectrum.hpp"

#include "core/constants.hpp"
#include "core/error.hpp"
#include "harmonic_inversion/fourier.hpp"
#include "harmonic_inversion/synthesize.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace twang {
namespace {

TEST(AmplitudeSpectrum, PeaksAtASteadySinusoidWithItsAmplitude) {
  SynthesisOptions options;
  options.offset = 40.0;
  const Trace trace = synthesize_sinusoids({{31.0, 0.0, 2.5, 0.7}}, options);
  const Spectrum spectrum = amplitude_spectrum(trace, trace.channels[0], 0.0, 2.0);
  const auto peak = std::max_element(spectrum.amplitude.begin(), spectrum.amplitude.end());
  const auto bin = static_cast<std::size_t>(peak - spectrum.amplitude.begin());
  // Bins of 1/8 Hz; half a bin off a peak 2 Hz wide costs the Hann window under 2 %.
  EXPECT_NEAR(spectrum.frequency_hz[bin], 31.0, 0.125);
  EXPECT_NEAR(*peak, 2.5, 0.02 * 2.5);
  EXPECT_EQ(spectrum.frequency_hz.front(), 0.0);
  EXPECT_NEAR(spectrum.frequency_hz.back(), 120.0, 0.2);
  EXPECT_LE(spectrum.frequency_hz[1], 1.0 / (4.0 * 2.0));
  EXPECT_LT(spectrum.amplitude[0], 0.01);  // the offset is gone
}

TEST(AmplitudeSpectrum, BridgesMissingSamples) {
  SynthesisOptions options;
  options.missing_part = 0.1;
  const Trace trace = synthesize_sinusoids({{5.0, 0.0, 1.0, 0.7}}, options);
  const Spectrum spectrum = amplitude_spectrum(trace, trace.channels[0], 0.0, 2.0);
  // At 48 samples a period a straight line over a gap misses by 1 - cos(pi / 48) at most: 0.2 %.
  EXPECT_NEAR(*std::max_element(spectrum.amplitude.begin(), spectrum.amplitude.end()), 1.0, 0.03);
}

TEST(AmplitudeSpectrum, RefusesFewerThanEightSamples) {
  const Trace trace = synthesize_sinusoids({{5.0, 0.0, 1.0, 0.7}});
  EXPECT_THROW(static_cast<void>(amplitude_spectrum(trace, trace.channels[0], 0.0, 0.027)),
               InputError);
}

TEST(FourierTransform, EqualsItsDefinition) {
  Eigen::VectorXd x(7);
  x << 1.0, -2.0, 0.5, 4.0, 0.0, 3.0, -1.0;
  const std::size_t length = 9;
  const auto transform = fourier_transform(x, length);
  ASSERT_EQ(transform.size(), length / 2 + 1);
  for (std::size_t k = 0; k < transform.size(); ++k) {
    std::complex<double> sum = 0.0;
    for (Eigen::Index n = 0; n < 7; ++n) {
      sum +=
          x(n) * std::polar(1.0, -kTwoPi * static_cast<double>(k) * static_cast<double>(n) / 9.0);
    }
    EXPECT_NEAR(std::abs(transform[k] - sum), 0.0, 1e-13);
  }
  EXPECT_EQ(fast_length(7), 8U);
  EXPECT_EQ(fast_length(961), 972U);  // 2² 3⁵
}

TEST(ModelSpectrum, IsThatOfTheTraceWhereTheModelIsTheTrace) {
  SynthesisOptions options;
  options.offset = 0.3;
  options.missing_part = 0.1;
  const Trace trace =
      synthesize_sinusoids({{20.0, 3.0, 1.0, 0.4}, {44.0, 9.0, 0.2, -2.0}}, options);
  const InversionResult result = invert_harmonics(trace, {"y"});
  ASSERT_EQ(result.modes.size(), 2U);
  const Spectrum model = model_spectrum(trace, result);
  const Spectrum whole =
      amplitude_spectrum(trace, trace.channels.front(), result.time_origin_s, result.time_end_s);
  ASSERT_EQ(model.frequency_hz, whole.frequency_hz);
  for (std::size_t k = 0; k < whole.amplitude.size(); ++k) {
    // Without noise the fit is the trace but for its own convergence, some 1e-9 of the amplitude.
    EXPECT_NEAR(model.amplitude[k], whole.amplitude[k], 1e-7);
  }
}

}  // namespace
}  // namespace twang
