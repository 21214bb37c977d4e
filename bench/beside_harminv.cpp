// SPDX-License-Identifier: GPL-3.0-or-later
// twang and harminv on the same files in the same run: time, memory, modes found, spurious modes
// kept, errors of f and d.
//
//   bench_beside_harminv --twang PATH [--samples 20000 1000000] [--modes 20] [--snr 30]
//                        [--repeats 3] [--folder DIR]
#include "core/constants.hpp"
#include "harmonic_inversion/synthesize.hpp"

#include <CLI/CLI.hpp>
#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/os.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>
#include <string>
#include <vector>

namespace {

using namespace twang;
namespace fs = std::filesystem;

struct Settings {
  std::string twang = "twang";
  fs::path folder = fs::temp_directory_path() / "twang_bench";
  std::vector<int> samples = {20000, 1000000};
  int modes = 20;
  double snr_db = 30.0;
  int repeats = 3;
};

constexpr double kRateHz = 1000.0;
constexpr double kLowHz = 40.0;
constexpr double kHighHz = 200.0;
/// The memory that twang may take: this, and so much a sample.
constexpr double kMemoryFloor = 100e6;
constexpr double kMemoryPerSample = 80.0;

struct Found {
  double frequency_hz = 0.0;
  double decay_per_s = 0.0;
};

struct Case {
  std::string name;
  double step_s = 0.0;
  double low_hz = 0.0;
  double high_hz = 0.0;
  std::vector<SinusoidTruth> truth;
  fs::path table;    ///< for twang
  fs::path numbers;  ///< for harminv
  std::size_t samples = 0;
};

struct Way {
  std::string name;
  std::vector<std::string> command;
  fs::path input;  ///< given on standard input; empty: none
  bool is_twang = false;
};

struct Outcome {
  double wall_s = std::numeric_limits<double>::infinity();
  double peak_bytes = 0.0;
  int status = -1;
  std::vector<Found> found;
};

bool is_installed(const std::string& program) {
  return std::system(("command -v '" + program + "' > /dev/null 2>&1").c_str()) == 0;
}

void run_child(const Way& way, const fs::path& output) {
  const int in = open(way.input.empty() ? "/dev/null" : way.input.c_str(), O_RDONLY);
  const int out = open(output.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
  const int err = open("/dev/null", O_WRONLY);
  if (in < 0 || out < 0 || err < 0) _exit(126);
  dup2(in, STDIN_FILENO);
  dup2(out, STDOUT_FILENO);
  dup2(err, STDERR_FILENO);
  std::vector<char*> arguments;
  std::vector<std::string> words = way.command;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  execvp(arguments[0], arguments.data());
  _exit(127);
}

/// Reads the rows of numbers in which the first two are f and d.
std::vector<Found> read_modes(const fs::path& output, bool is_twang) {
  std::vector<Found> out;
  std::ifstream file(output);
  for (std::string line; std::getline(file, line);) {
    double a = 0.0;
    double b = 0.0;
    double c = 0.0;
    // twang: f, its sigma, d, its sigma ...; harminv: f, d, Q, amplitude, phase, error.
    if (is_twang && std::sscanf(line.c_str(), "%lf %lf %lf", &a, &b, &c) == 3) {
      out.push_back({a, c});
    } else if (!is_twang && std::sscanf(line.c_str(), "%lf, %lf", &a, &b) == 2 && a > 0.0) {
      out.push_back({a, b});
    }
  }
  return out;
}

Outcome run(const Way& way, const fs::path& folder) {
  const fs::path output = folder / "modes.txt";
  const auto start = std::chrono::steady_clock::now();
  const pid_t child = fork();
  if (child == 0) run_child(way, output);
  Outcome out;
  rusage usage{};
  int status = 0;
  wait4(child, &status, 0, &usage);
  out.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  out.peak_bytes = 1024.0 * static_cast<double>(usage.ru_maxrss);
  out.status = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  out.found = read_modes(output, way.is_twang);
  return out;
}

void write(Case& c, const Trace& trace, const fs::path& folder) {
  c.samples = trace.num_samples();
  c.table = folder / (c.name + ".csv");
  c.numbers = folder / (c.name + ".txt");
  auto table = fmt::output_file(c.table.string());
  auto numbers = fmt::output_file(c.numbers.string());
  table.print("time_s,y\n");
  for (std::size_t i = 0; i < trace.num_samples(); ++i) {
    table.print("{},{}\n", trace.time_s[i], trace.channels[0].values[i]);
    numbers.print("{}\n", trace.channels[0].values[i]);
  }
}

/// Modes spread over the band, that decay by two to eight e-folds within the record.
Case many_modes(int samples, const Settings& settings) {
  Case out;
  out.name = fmt::format("{}_samples", samples);
  out.step_s = 1.0 / kRateHz;
  out.low_hz = kLowHz;
  out.high_hz = kHighHz;
  std::mt19937 generator(3);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  SynthesisOptions options;
  options.rate_hz = kRateHz;
  options.duration_s = (samples - 1) / kRateHz;
  options.noise_sigma = std::pow(10.0, -settings.snr_db / 20.0);
  for (int k = 0; k < settings.modes; ++k) {
    const double place = (k + 0.2 + 0.6 * uniform(generator)) / settings.modes;
    out.truth.push_back({kLowHz + (kHighHz - kLowHz) * place,
                         (2.0 + 6.0 * uniform(generator)) / options.duration_s,
                         std::pow(10.0, -uniform(generator)),
                         kTwoPi * uniform(generator) - kPi});
  }
  write(out, synthesize_sinusoids(out.truth, options), settings.folder);
  return out;
}

/// Fifteen modes in 128 samples without noise [arXiv 1606.00391].
Case fifteen_modes(const Settings& settings) {
  const std::vector<double> omega = {32.85,
                                     36.51,
                                     38.29,
                                     48.82,
                                     105.63,
                                     146.96,
                                     183.24,
                                     191.10,
                                     217.34,
                                     241.39,
                                     253.59,
                                     283.60,
                                     298.20,
                                     299.85,
                                     304.95};
  const std::vector<double> gamma = {4.61,
                                     9.44,
                                     12.95,
                                     0.09,
                                     9.24,
                                     14.88,
                                     10.19,
                                     7.46,
                                     11.21,
                                     2.18,
                                     11.03,
                                     9.64,
                                     4.42,
                                     12.25,
                                     9.20};
  Case out;
  out.name = "fifteen_modes";
  out.step_s = 1.0 / 128.0;
  out.low_hz = 4.0;
  out.high_hz = 60.0;
  for (std::size_t k = 0; k < omega.size(); ++k) {
    out.truth.push_back({omega[k] / kTwoPi, gamma[k], 1.0, 0.5 * kPi});
  }
  SynthesisOptions options;
  options.rate_hz = 128.0;
  options.duration_s = 127.0 / 128.0;
  write(out, synthesize_sinusoids(out.truth, options), settings.folder);
  return out;
}

/// A silicone beam: Q = 5, which harminv drops unless told otherwise.
Case heavy_mode(const Settings& settings) {
  Case out;
  out.name = "heavy_mode";
  out.step_s = 1.0 / 240.0;
  out.low_hz = 2.0;
  out.high_hz = 117.0;
  out.truth = {{20.0, kTwoPi * 2.0, 1.0, 0.6}, {61.0, 30.0, 0.3, 1.0}};
  SynthesisOptions options;
  options.noise_sigma = 0.01;
  write(out, synthesize_sinusoids(out.truth, options), settings.folder);
  return out;
}

std::vector<Way> ways_of(const Case& c, const Settings& settings) {
  const std::string step = fmt::format("{}", c.step_s);
  const std::string band = fmt::format("{}-{}", c.low_hz, c.high_hz);
  std::vector<Way> out;
  out.push_back({"harminv", {"harminv", "-t", step, band}, c.numbers, false});
  out.push_back(
      {"harminv -F -Q 0", {"harminv", "-t", step, "-F", "-Q", "0", band}, c.numbers, false});
  out.push_back({"harminv -F -Q 0 -d 1 -a 0.01",
                 {"harminv", "-t", step, "-F", "-Q", "0", "-d", "1", "-a", "0.01", band},
                 c.numbers,
                 false});
  out.push_back({"twang", {settings.twang, "invert", c.table.string()}, {}, true});
  out.push_back({"twang --band",
                 {settings.twang,
                  "invert",
                  c.table.string(),
                  "--band",
                  fmt::format("{}", c.low_hz),
                  fmt::format("{}", c.high_hz)},
                 {},
                 true});
  return out;
}

/// How the modes that were found lie to those that are there, each taken at most once.
struct Score {
  int found = 0;
  int spurious = 0;
  double frequency_error = 0.0;  ///< largest, in parts of f
  double decay_error = 0.0;      ///< largest, in parts of d
};

Score score(const Case& c, std::vector<Found> found) {
  Score out;
  for (const SinusoidTruth& s : c.truth) {
    // Closer than half a line width, or half a bin of the record where that is more.
    const double width =
        0.5 * std::max(s.decay_per_s / kTwoPi, 1.0 / (static_cast<double>(c.samples) * c.step_s));
    const auto distance = [&](const Found& f) {
      return std::hypot(f.frequency_hz - s.frequency_hz, (f.decay_per_s - s.decay_per_s) / kTwoPi);
    };
    const auto nearest =
        std::min_element(found.begin(), found.end(), [&](const Found& a, const Found& b) {
          return distance(a) < distance(b);
        });
    if (nearest == found.end() || distance(*nearest) > width) continue;
    ++out.found;
    out.frequency_error =
        std::max(out.frequency_error, std::abs(nearest->frequency_hz / s.frequency_hz - 1.0));
    out.decay_error =
        std::max(out.decay_error, std::abs(nearest->decay_per_s / s.decay_per_s - 1.0));
    found.erase(nearest);
  }
  out.spurious = static_cast<int>(found.size());
  return out;
}

void compare(const Case& c, const Settings& settings) {
  fmt::print("{}: {} modes, {} samples, {:g} to {:g} Hz\n",
             c.name,
             c.truth.size(),
             c.samples,
             c.low_hz,
             c.high_hz);
  fmt::print("{:>30}{:>9}{:>8}{:>9}{:>7}{:>10}{:>11}{:>11}\n",
             "",
             "wall s",
             "ratio",
             "MB",
             "found",
             "spurious",
             "f error",
             "d error");
  double reference_s = 0.0;
  for (const Way& way : ways_of(c, settings)) {
    Outcome best;
    for (int i = 0; i < settings.repeats; ++i) {
      Outcome now = run(way, settings.folder);
      if (now.wall_s < best.wall_s) best = std::move(now);
    }
    if (reference_s == 0.0) reference_s = best.wall_s;
    const Score s = score(c, best.found);
    const double allowed = kMemoryFloor + kMemoryPerSample * static_cast<double>(c.samples);
    fmt::print("{:>30}{:>9.3f}{:>8.2f}{:>9.1f}{:>7}{:>10}{:>11.2g}{:>11.2g}{}{}\n",
               way.name,
               best.wall_s,
               best.wall_s / reference_s,
               1e-6 * best.peak_bytes,
               s.found,
               s.spurious,
               s.frequency_error,
               s.decay_error,
               way.is_twang && best.peak_bytes > allowed ? "  TOO MUCH MEMORY" : "",
               best.status == 0 ? "" : fmt::format("  exit code {}", best.status));
    std::fflush(stdout);
  }
}

}  // namespace

int main(int argc, char** argv) {
  Settings settings;
  CLI::App app("twang beside harminv");
  app.add_option("--twang", settings.twang, "the command to measure")->capture_default_str();
  app.add_option("--folder", settings.folder, "where the files are kept");
  app.add_option("--samples", settings.samples, "lengths of the long records")
      ->capture_default_str();
  app.add_option("--modes", settings.modes, "modes of the long records")->capture_default_str();
  app.add_option("--snr", settings.snr_db, "unit amplitude over sigma [dB]")->capture_default_str();
  app.add_option("--repeats", settings.repeats, "runs, of which the fastest counts")
      ->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  for (const std::string& program : {std::string("harminv"), settings.twang}) {
    if (is_installed(program)) continue;
    fmt::print("skipped: {} is not here\n", program);
    return 0;
  }
  // One core for both.
  setenv("OMP_NUM_THREADS", "1", 1);
  setenv("OPENBLAS_NUM_THREADS", "1", 1);
  fs::create_directories(settings.folder);
  compare(fifteen_modes(settings), settings);
  compare(heavy_mode(settings), settings);
  for (const int samples : settings.samples) compare(many_modes(samples, settings), settings);
  return 0;
}
