// SPDX-License-Identifier: GPL-3.0-or-later
// How close the inversion comes to the Cramer-Rao bound, whether its sigmas are honest, how often
// it finds a mode in noise and how often it misses one.
//
//   bench_monte_carlo [--draws 2000] [--records 1000] [--seed 1] [--frequency 20 60] [--snr 20 30
//   40 60]
//                     [--damping 0.005 0.02 0.05 0.1 0.2 0.4]
#include "bench/inversion_draws.hpp"
#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <cstdio>
#include <string>
#include <vector>

namespace {

using namespace twang::bench;

struct Settings {
  int draws = 2000;
  int records = 1000;
  std::uint32_t seed = 1;
  std::vector<double> frequencies_hz = {20.0, 60.0};
  std::vector<double> snrs_db = {20.0, 30.0, 40.0, 60.0};
  std::vector<double> damping_ratios = {0.005, 0.02, 0.05, 0.1, 0.2, 0.4};
};

/// Bounds that hold from here on [dB].
constexpr double kBoundedFromDb = 30.0;

bool is_within(const Spread& spread) {
  return spread.rmse_over_bound <= 1.1 && spread.within_one >= 0.65 && spread.within_one <= 0.72 &&
         spread.within_two >= 0.935 && spread.within_two <= 0.97;
}

std::string columns(const Spread& spread) {
  return fmt::format("{:>8.3f}{:>7.1f}{:>7.1f}",
                     spread.rmse_over_bound,
                     100.0 * spread.within_one,
                     100.0 * spread.within_two);
}

int print_table(const Settings& settings) {
  fmt::print("{} draws each, 481 samples at 240 Hz, phases at random\n", settings.draws);
  fmt::print("{:>6}{:>6}{:>8} |{:>22} |{:>22} |{:>7}{:>7}\n",
             "dB",
             "f",
             "zeta",
             "f: rmse/bound 1s% 2s%",
             "d: rmse/bound 1s% 2s%",
             "missed",
             "extra");
  int outside = 0;
  std::uint32_t seed = settings.seed;
  for (const double snr_db : settings.snrs_db) {
    for (const double frequency_hz : settings.frequencies_hz) {
      for (const double damping_ratio : settings.damping_ratios) {
        const DrawStatistics s =
            draw_sinusoids({frequency_hz, damping_ratio, snr_db}, settings.draws, seed);
        seed += static_cast<std::uint32_t>(settings.draws);  // rows do not share their noise
        const bool bounded = snr_db >= kBoundedFromDb;
        const bool fine = s.missed == 0 && is_within(s.frequency) && is_within(s.decay);
        outside += bounded && !fine ? 1 : 0;
        fmt::print("{:>6g}{:>6g}{:>8g} |{} |{} |{:>7}{:>7}{}\n",
                   snr_db,
                   frequency_hz,
                   damping_ratio,
                   columns(s.frequency),
                   columns(s.decay),
                   s.missed,
                   s.extra,
                   fine      ? ""
                   : bounded ? "  OUTSIDE"
                             : "  (not bounded)");
        std::fflush(stdout);
      }
    }
  }
  return outside;
}

}  // namespace

int main(int argc, char** argv) {
  Settings settings;
  CLI::App app("Errors of the harmonic inversion beside the Cramer-Rao bound");
  app.add_option("--draws", settings.draws, "records of each row")->capture_default_str();
  app.add_option("--records", settings.records, "records of noise, and of a mode of 20 sigma")
      ->capture_default_str();
  app.add_option("--seed", settings.seed, "of the first record")->capture_default_str();
  app.add_option("--frequency", settings.frequencies_hz, "[Hz]")->capture_default_str();
  app.add_option("--snr", settings.snrs_db, "amplitude over sigma [dB]")->capture_default_str();
  app.add_option("--damping", settings.damping_ratios, "damping ratios")->capture_default_str();
  CLI11_PARSE(app, argc, argv);

  const int outside = print_table(settings);
  fmt::print("rows from {:g} dB outside the bounds: {}\n", kBoundedFromDb, outside);
  const int alarms = count_false_alarms(settings.records, settings.seed);
  fmt::print("false modes in {} records of white noise: {}\n", settings.records, alarms);
  const int found = count_detections(settings.records, settings.seed);
  fmt::print("modes of 20 sigma found in {} records: {}\n", settings.records, found);
  return outside == 0 && found == settings.records && 100 * alarms <= settings.records ? 0 : 1;
}
