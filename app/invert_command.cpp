// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/commands.hpp"
#include "app/options.hpp"
#include "app/terminal.hpp"
#include "core/error.hpp"
#include "core/trace_file.hpp"
#include "harmonic_inversion/invert_harmonics.hpp"

#include <fmt/format.h>

#include <memory>
#include <utility>

namespace twang::app {
namespace {

struct InvertCommand {
  std::string trace;
  std::vector<std::string> columns;
  std::string time_column = "time_s";
  InversionFlags flags;
  bool joint = false;
  std::string json;
};

std::string table_of(const InversionResult& result) {
  std::string text = fmt::format("window {:.4f} .. {:.4f} s, {} samples; {}\n",
                                 result.time_origin_s,
                                 result.time_end_s,
                                 result.num_samples,
                                 result.method);
  if (!result.usable()) return text + fmt::format("no mode: {}\n", result.message);
  text += fmt::format("{:>12} {:>10} {:>12} {:>10} {:>10} {:>12} {:>9}\n",
                      "f [Hz]",
                      "sigma",
                      "d [1/s]",
                      "sigma",
                      "zeta [-]",
                      "amplitude",
                      "phase");
  for (const DampedSinusoid& mode : result.modes) {
    const SinusoidInChannel& first = mode.channels.front();
    text += fmt::format("{:12.5f} {:10.2g} {:12.5f} {:10.2g} {:10.5f} {:12.5g} {:9.4f}\n",
                        mode.frequency_hz,
                        mode.frequency_sigma_hz,
                        mode.decay_per_s,
                        mode.decay_sigma_per_s,
                        mode.damping_ratio(),
                        first.amplitude,
                        first.phase_rad);
  }
  text += fmt::format(
      "residual {:.3g} rms, {:.1f} dB below the strongest\n", result.residual_rms, result.snr_db);
  for (const std::string& note : result.notes) text += "note: " + note + "\n";
  return text;
}

void run(const InvertCommand& command) {
  const Trace trace = read_trace_csv(command.trace, command.time_column);
  InversionOptions options = command.flags.options();
  options.progress = terminal_progress();
  const std::vector<std::string> columns =
      command.columns.empty() ? default_columns(trace) : command.columns;
  if (columns.empty())
    throw InputError(fmt::format("{}: has no column to invert beside the time", command.trace));
  std::vector<std::pair<std::string, InversionResult>> results;
  try {
    if (command.joint || columns.size() == 1) {
      results.emplace_back(fmt::format("{}", fmt::join(columns, ", ")),
                           invert_harmonics(trace, columns, options));
    } else {
      for (const std::string& column : columns) {
        results.emplace_back(column, invert_harmonics(trace, {column}, options));
      }
    }
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", command.trace, error.what()));
  }
  if (!command.json.empty()) {
    write_json(
        command.json,
        results.size() == 1 ? modes_to_json(results.front().second) : modes_to_json(results));
  }
  if (command.json == "-") return;
  for (const auto& [name, result] : results) {
    if (results.size() > 1) print_result(name + ":");
    print_result(table_of(result));
  }
}

}  // namespace

void add_invert_command(CLI::App& cli) {
  CLI::App* sub = cli.add_subcommand("invert", "Find the damped sinusoids of a trace");
  auto command = std::make_shared<InvertCommand>();
  sub->add_option("trace", command->trace, "table with a time column (*.csv)")->required();
  sub->add_option("--column", command->columns, "column to invert; may be repeated")
      ->allow_extra_args(false);
  sub->add_option("--time-column", command->time_column, "column that holds the time [s]")
      ->capture_default_str();
  sub->add_flag("--joint", command->joint, "all columns share their poles");
  sub->add_option(
      "--json", command->json, "machine-readable result: a file, or - for standard output");
  command->flags.add_to(*sub);
  sub->callback([command] { run(*command); });
}

}  // namespace twang::app
