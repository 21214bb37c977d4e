// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/constants.hpp"
#include "core/error.hpp"
#include "harmonic_inversion/invert_harmonics.hpp"
#include "harmonic_inversion/synthesize.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace twang {
namespace {

TEST(InvertHarmonics, RefusesWhatCannotBeInverted) {
  Trace trace = synthesize_sinusoids({{17.0, 2.0, 1.0, 0.4}});
  EXPECT_THROW(static_cast<void>(invert_harmonics({}, {"y"})), InputError);
  EXPECT_THROW(static_cast<void>(invert_harmonics(trace, {})), InputError);
  try {
    static_cast<void>(invert_harmonics(trace, {"z"}));
    FAIL() << "a missing column must be refused";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("column z"), std::string::npos);
  }
  for (std::size_t i = 0; i < trace.num_samples(); ++i) {
    if (i % 70 != 0) trace.channels[0].values[i] = kNaN;
  }
  EXPECT_EQ(Trace::num_finite(trace.channels[0]), 7U);
  EXPECT_THROW(static_cast<void>(invert_harmonics(trace, {"y"})), InputError);
}

TEST(InversionOptions, RefusesEachFieldOutOfRange) {
  EXPECT_NO_THROW(InversionOptions{}.check());
  const auto refused = [](auto&& spoil) {
    InversionOptions options;
    spoil(options);
    EXPECT_THROW(options.check(), InputError);
  };
  refused([](InversionOptions& o) { o.band_hz = Band{-1.0, 5.0}; });
  refused([](InversionOptions& o) { o.band_hz = Band{5.0, 5.0}; });
  refused([](InversionOptions& o) { o.band_hz = Band{5.0, kInfinity}; });
  refused([](InversionOptions& o) { o.start_s = kNaN; });
  refused([](InversionOptions& o) { o.end_s = kInfinity; });
  refused([](InversionOptions& o) {
    o.start_s = 2.0;
    o.end_s = 1.0;
  });
  refused([](InversionOptions& o) { o.max_modes = -1; });
  InversionOptions beyond;
  beyond.band_hz = Band{130.0, 140.0};
  EXPECT_THROW(static_cast<void>(
                   invert_harmonics(synthesize_sinusoids({{17.0, 2.0, 1.0, 0.4}}), {"y"}, beyond)),
               InputError);
}

TEST(DefaultColumns, PreferTheObservableAndSkipSigmasAndOffsets) {
  Trace trace;
  for (const char* name : {"tip.x_mm", "tip.z_mm", "tip.sigma_mm", "tip.time_offset_s"}) {
    trace.channels.push_back({name, {}});
  }
  EXPECT_EQ(default_columns(trace), (std::vector<std::string>{"tip.x_mm", "tip.z_mm"}));
  trace.channels.push_back({"observable_mm", {}});
  EXPECT_EQ(default_columns(trace), std::vector<std::string>{"observable_mm"});
}

}  // namespace
}  // namespace twang
