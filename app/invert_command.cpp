// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/commands.hpp"
#include "app/options.hpp"
#include "app/terminal.hpp"
#include "core/error.hpp"
#include "core/trace_file.hpp"
#include "harmonic_inversion/decay_checks.hpp"
#include "harmonic_inversion/invert_harmonics.hpp"
#include "harmonic_inversion/releases.hpp"
#include "report/material_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <utility>

namespace twang::app {
namespace {

struct InvertCommand {
  std::string trace;
  std::vector<std::string> columns;
  std::vector<std::string> sigma_columns;
  std::string time_column = "time_s";
  InversionFlags flags;
  bool joint = false;
  bool each_release = false;
  std::string json;
};

/// One line a check; nothing for none.
std::string text_of(const std::vector<DecayCheck>& checks) {
  std::string text;
  for (const DecayCheck& check : checks) {
    if (!check.usable()) {
      text += fmt::format("check by {}: {}\n", check.method, check.message);
      continue;
    }
    text += fmt::format("check by {}: d {} 1/s, f {} Hz ({} points)\n",
                        check.method,
                        text_with_sigma(check.decay_per_s, check.decay_sigma_per_s),
                        text_with_sigma(check.frequency_hz, check.frequency_sigma_hz),
                        check.num_points);
  }
  return text;
}

std::string table_of(const InversionResult& result) {
  std::string text = fmt::format("window {:.4f} .. {:.4f} s, {} samples; {}\n",
                                 result.time_origin_s,
                                 result.time_end_s,
                                 result.num_samples,
                                 result.method);
  if (!result.usable()) return text + fmt::format("no mode: {}\n", result.message);
  text += fmt::format("{:>12} {:>10} {:>12} {:>10} {:>10} {:>10} {:>12} {:>9}\n",
                      "f [Hz]",
                      "sigma",
                      "d [1/s]",
                      "sigma",
                      "zeta [-]",
                      "sigma",
                      "amplitude",
                      "phase");
  for (const DampedSinusoid& mode : result.modes) {
    const SinusoidInChannel& first = mode.channels.front();
    text += fmt::format("{:12.5f} {:10.2g} {:12.5f} {:10.2g} {:10.5f} {:10.2g} {:12.5g} {:9.4f}\n",
                        mode.frequency_hz,
                        mode.frequency_sigma_hz,
                        mode.decay_per_s,
                        mode.decay_sigma_per_s,
                        mode.damping_ratio(),
                        mode.damping_ratio_sigma(),
                        first.amplitude,
                        first.phase_rad);
  }
  text += fmt::format(
      "residual {:.3g} rms, {:.1f} dB below the strongest\n", result.residual_rms, result.snr_db);
  text += text_of(result.decay_checks);
  for (const std::string& remark : result.remarks) text += "note: " + remark + "\n";
  for (const std::string& note : result.notes) text += "warning: " + note + "\n";
  return text;
}

/// The releases side by side, each alone.
std::string table_of(const RepeatedInversion& repeated) {
  std::string text = fmt::format("{} release{}, together: ",
                                 repeated.alone.size(),
                                 repeated.alone.size() == 1 ? "" : "s") +
                     table_of(repeated.joint);
  text += fmt::format("{:>12} {:>12} {:>10} {:>12} {:>10} {:>10} {:>10}\n",
                      "release [s]",
                      "f [Hz]",
                      "sigma",
                      "d [1/s]",
                      "sigma",
                      "zeta [-]",
                      "sigma");
  for (std::size_t n = 0; n < repeated.alone.size(); ++n) {
    const InversionResult& alone = repeated.alone[n];
    const DampedSinusoid* mode = repeated.mode_alone(n);
    text += fmt::format("{:12.4f} ", alone.release_s.value_or(alone.time_origin_s));
    text += mode == nullptr ? fmt::format("{}\n", alone.message)
                            : fmt::format("{:12.5f} {:10.2g} {:12.5f} {:10.2g} {:10.5f} {:10.2g}\n",
                                          mode->frequency_hz,
                                          mode->frequency_sigma_hz,
                                          mode->decay_per_s,
                                          mode->decay_sigma_per_s,
                                          mode->damping_ratio(),
                                          mode->damping_ratio_sigma());
  }
  if (std::isfinite(repeated.frequency_scatter_hz)) {
    text += fmt::format("between releases f scatters by {:.2g} Hz, d by {:.2g} 1/s\n",
                        repeated.frequency_scatter_hz,
                        repeated.decay_scatter_per_s);
  }
  return text;
}

/// Columns that are inverted together, with their table and their JSON fields.
using Groups = std::vector<std::vector<std::string>>;

Groups groups_of(const InvertCommand& command, const Trace& trace) {
  std::vector<std::string> columns =
      command.columns.empty() ? default_columns(trace) : command.columns;
  if (command.columns.empty()) {
    std::erase_if(columns, [&](const std::string& name) {
      const auto& sigmas = command.sigma_columns;
      return std::find(sigmas.begin(), sigmas.end(), name) != sigmas.end();
    });
  }
  if (columns.empty())
    throw InputError(fmt::format("{}: has no column to invert beside the time", command.trace));
  if (command.joint) return {columns};
  Groups groups;
  for (const std::string& column : columns) groups.push_back({column});
  return groups;
}

/// The options for the columns of one group, of all that are inverted.
InversionOptions options_of(const InvertCommand& command, const Groups& groups, std::size_t group) {
  InversionOptions options = command.flags.options();
  options.progress = terminal_progress();
  options.sigma_columns = command.sigma_columns;
  if (options.sigma_columns.size() < 2 || groups.size() == 1) return options;
  if (options.sigma_columns.size() != groups.size()) {
    throw InputError(fmt::format("--sigma-column is given {} times, must be once or once a column",
                                 options.sigma_columns.size()));
  }
  options.sigma_columns = {command.sigma_columns[group]};
  return options;
}

/// Inverts each group by `invert`, then prints tables and writes JSON.
template <class Result>
void invert_groups(
    const InvertCommand& command,
    const Groups& groups,
    const std::function<Result(const std::vector<std::string>&, const InversionOptions&)>& invert) {
  std::vector<std::pair<std::string, Result>> results;
  try {
    for (std::size_t g = 0; g < groups.size(); ++g) {
      results.emplace_back(fmt::format("{}", fmt::join(groups[g], ", ")),
                           invert(groups[g], options_of(command, groups, g)));
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

void run(const InvertCommand& command) {
  const Trace trace = read_trace_csv(command.trace, command.time_column);
  const Groups groups = groups_of(command, trace);
  if (command.each_release) {
    invert_groups<RepeatedInversion>(
        command, groups, [&](const auto& columns, const auto& options) {
          const std::vector<Trace> releases = cut_at_releases(trace, columns, options);
          InversionOptions within = options;  // the parts are cut already
          within.start_s.reset();
          within.end_s.reset();
          RepeatedInversion repeated = compare_repeats(releases, columns, within);
          for (std::size_t n = 0; n < releases.size(); ++n) {
            repeated.alone[n] = with_decay_checks(std::move(repeated.alone[n]), releases[n]);
          }
          return repeated;
        });
  } else {
    invert_groups<InversionResult>(command, groups, [&](const auto& columns, const auto& options) {
      return with_decay_checks(invert_harmonics(trace, columns, options), trace);
    });
  }
}

}  // namespace

void add_invert_command(CLI::App& cli) {
  CLI::App* sub = cli.add_subcommand("invert", "Find the damped sinusoids of a trace");
  auto command = std::make_shared<InvertCommand>();
  sub->add_option("trace", command->trace, "table with a time column (*.csv)")->required();
  sub->add_option("--column", command->columns, "column to invert; may be repeated")
      ->allow_extra_args(false);
  sub->add_option("--sigma-column",
                  command->sigma_columns,
                  "column with the standard deviations of the samples, once for all columns or "
                  "once for each; default: NAME.sigma_* if there")
      ->allow_extra_args(false);
  sub->add_option("--time-column", command->time_column, "column that holds the time [s]")
      ->capture_default_str();
  sub->add_flag("--each-release",
                command->each_release,
                "every release of the record, together and each alone");
  sub->add_flag("--joint", command->joint, "all columns share their poles");
  sub->add_option(
      "--json", command->json, "machine-readable result: a file, or - for standard output");
  command->flags.add_to(*sub);
  sub->callback([command] { run(*command); });
}

}  // namespace twang::app
