// SPDX-License-Identifier: GPL-3.0-or-later
#include "simulate/run_scene.hpp"

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "core/sha256.hpp"
#include "core/text.hpp"
#include "fem/threads.hpp"
#include "simulate/checkpoint.hpp"
#include "simulate/detail/scene_files.hpp"
#include "simulate/detail/state_stream.hpp"
#include "simulate/simulated_body.hpp"

#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <system_error>

namespace twang {
namespace {

using Clock = std::chrono::steady_clock;

constexpr const char* kCheckpointName = "checkpoint.bin";
constexpr double kSameTime = 1e-9;  // of an interval, round-off of a quotient [-]

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

double peak_memory_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  constexpr double kBytesPerKilobyte = 1024.0;
  return kBytesPerKilobyte * static_cast<double>(usage.ru_maxrss);
}

void make_folder(const std::filesystem::path& folder) {
  std::error_code error;
  if (std::filesystem::exists(folder, error) && !std::filesystem::is_directory(folder, error))
    throw InputError(
        fmt::format("{}: is a file, must be a folder to write results into", folder.string()));
  std::filesystem::create_directories(folder, error);
  if (error)
    throw InputError(fmt::format("{}: cannot be made: {}", folder.string(), error.message()));
}

/// Whether an interval of time ends with step `step`: its multiples fall to the first step at or
/// after them.
bool interval_ends(double interval_s, double step_s, int step) {
  const double multiple = std::floor(step * step_s / interval_s + kSameTime);
  const double first_step = std::ceil(multiple * interval_s / step_s - kSameTime);
  return static_cast<int>(first_step) == step;
}

/// A scene on its way.
class SceneRun {
 public:
  SceneRun(const Scene& scene, const SceneOptions& options)
      : m_scene(scene), m_options(options), m_last(count_steps(scene.duration_s, scene.step_s)) {
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
      report_progress(options.progress, {"meshing", static_cast<double>(i), 0.0, "bodies"});
      m_bodies.emplace_back(scene, i);
    }
    if (options.resume) {
      restore();
    } else {
      begin();
    }
    m_summary.mesh_s = seconds_since(m_begin);
  }

  SceneSummary finish() {
    m_summary.run.termination = Termination::Converged;
    while (m_step < m_last) {
      if (m_options.progress &&
          !m_options.progress(
              {"simulating", static_cast<double>(m_step), static_cast<double>(m_last), "steps"}))
        stop();
      if (!take_step()) break;
    }
    const auto output_begin = Clock::now();
    if (m_summary.usable()) {
      save();
    } else {
      static_cast<void>(m_files->sync());
    }
    m_output_s += seconds_since(output_begin);
    return complete_summary();
  }

 private:
  [[nodiscard]] std::filesystem::path checkpoint_path() const {
    return m_options.folder / kCheckpointName;
  }

  [[nodiscard]] MechanicalState measure() const {
    MechanicalState now;
    for (const SimulatedBody& body : m_bodies) now += body.mechanical_state();
    return now;
  }

  void begin() {
    for (SimulatedBody& body : m_bodies) body.settle(m_options.progress);
    std::error_code ignored;
    std::filesystem::remove(checkpoint_path(), ignored);  // of another run
    m_files = std::make_unique<detail::SceneFiles>(
        m_options.folder, m_bodies, m_scene.output.vtu, std::nullopt);
    const MechanicalState now = measure();
    m_ledger = EnergyLedger(now);
    write_rows(now);
  }

  bool take_step() {
    LedgerWork work;
    for (SimulatedBody& body : m_bodies) {
      const StepReport report = body.step(m_step + 1);
      m_summary.run.add(report);
      if (report.termination != Termination::Converged) {
        m_summary.run.termination = report.termination;
        m_summary.run.message = fmt::format(
            "the step of \"{}\" at {} s failed, halved {} times too: {}; a step_s below {} may do",
            body.name(),
            m_step * m_scene.step_s,
            IntegratorOptions{}.max_halvings,
            report.message,
            m_scene.step_s);
        return false;
      }
      work.external_j += body.last_work().external_j;
      work.damping_j += body.last_work().damping_j;
    }
    ++m_step;
    m_ledger.add(work);
    const auto begin = Clock::now();
    write_rows(measure());
    const auto& every = m_scene.output.checkpoint_every_s;
    if (every && m_step < m_last && interval_ends(*every, m_scene.step_s, m_step)) save();
    m_output_s += seconds_since(begin);
    return true;
  }

  void write_rows(const MechanicalState& now) {
    const double time_s = m_step * m_scene.step_s;
    m_largest_energy_j = std::max(
        {m_largest_energy_j, now.kinetic_j, now.elastic_j, std::abs(m_ledger.work().external_j)});
    m_largest_remainder_j = std::max(m_largest_remainder_j, std::abs(m_ledger.remainder_j(now)));
    m_files->add_energy(time_s, now, m_ledger);
    const auto& every = m_scene.output.every_s;
    if (every && !interval_ends(*every, m_scene.step_s, m_step)) return;
    m_files->add_frame(time_s, m_bodies);
    m_files->flush();
  }

  /// Ctrl-C: what there is stays, and can be gone on from.
  [[noreturn]] void stop() {
    save();
    throw Cancelled(fmt::format("interrupted at {} s of {} s, --resume goes on from there",
                                rounded_text(m_step * m_scene.step_s, 6),
                                exact_text(m_scene.duration_s)));
  }

  void save();
  void restore();
  SceneSummary complete_summary();

  const Scene& m_scene;
  const SceneOptions& m_options;
  const int m_last;
  int m_step = 0;
  std::vector<SimulatedBody> m_bodies;
  std::unique_ptr<detail::SceneFiles> m_files;
  EnergyLedger m_ledger;
  double m_largest_energy_j = 0.0;
  double m_largest_remainder_j = 0.0;
  SceneSummary m_summary;
  double m_output_s = 0.0;
  double m_wall_before_s = 0.0;  // of the runs that this one continues
  Clock::time_point m_begin = Clock::now();
};

void SceneRun::save() {
  const detail::FileLengths lengths = m_files->sync();
  detail::StateWriter writer;
  writer.write_text(m_scene.sha256);
  writer.write_count(m_step);
  writer.write(m_ledger.start_j());
  const LedgerWork& work = m_ledger.work();
  for (const double value : {work.external_j,
                             work.damping_j,
                             work.friction_j,
                             work.impact_j,
                             m_largest_energy_j,
                             m_largest_remainder_j,
                             m_wall_before_s + seconds_since(m_begin),
                             m_output_s})
    writer.write(value);
  const RunSummary& run = m_summary.run;
  for (const long value :
       {run.newton_iterations, run.linear_iterations, run.factorizations, run.halved_steps})
    writer.write_count(value);
  for (const double value : {run.phases.forces_s,
                             run.phases.products_s,
                             run.phases.factorization_s,
                             run.phases.preconditioner_s})
    writer.write(value);
  for (const std::int64_t length : {lengths.motion, lengths.probes, lengths.energy})
    writer.write_count(length);
  writer.write_count(lengths.frames);
  for (const double time : m_files->frame_times()) writer.write(time);
  for (const SimulatedBody& body : m_bodies) body.save(writer);
  write_checkpoint(checkpoint_path(), writer.bytes());
}

void SceneRun::restore() {
  const std::string state = read_checkpoint(checkpoint_path());
  detail::StateReader reader(state, checkpoint_path().string());
  if (reader.read_text() != m_scene.sha256)
    throw InputError(
        fmt::format("{}: is of another scene, must be of {} and the files it names, unchanged",
                    checkpoint_path().string(),
                    m_scene.file.string()));
  m_step = static_cast<int>(reader.read_count());
  const double start_j = reader.read_number();
  LedgerWork work;
  for (double* value : {&work.external_j,
                        &work.damping_j,
                        &work.friction_j,
                        &work.impact_j,
                        &m_largest_energy_j,
                        &m_largest_remainder_j,
                        &m_wall_before_s,
                        &m_output_s})
    *value = reader.read_number();
  m_ledger = EnergyLedger(start_j, work);
  RunSummary& run = m_summary.run;
  for (long* value :
       {&run.newton_iterations, &run.linear_iterations, &run.factorizations, &run.halved_steps})
    *value = reader.read_count();
  for (double* value : {&run.phases.forces_s,
                        &run.phases.products_s,
                        &run.phases.factorization_s,
                        &run.phases.preconditioner_s})
    *value = reader.read_number();
  detail::FileLengths lengths;
  for (std::int64_t* length : {&lengths.motion, &lengths.probes, &lengths.energy})
    *length = reader.read_count();
  lengths.frames = reader.read_count();
  std::vector<double> frame_times;
  for (std::int64_t i = 0; i < lengths.frames; ++i) frame_times.push_back(reader.read_number());
  m_files =
      std::make_unique<detail::SceneFiles>(m_options.folder, m_bodies, m_scene.output.vtu, lengths);
  m_files->set_frame_times(std::move(frame_times));
  for (SimulatedBody& body : m_bodies) body.restore(reader);
  m_summary.resumed_at_step = m_step;
}

SceneSummary SceneRun::complete_summary() {
  SceneSummary& summary = m_summary;
  summary.run.steps = m_step;
  summary.simulated_s = m_step * m_scene.step_s;
  if (summary.usable())
    summary.run.message = fmt::format("{} steps of {} s", m_step, m_scene.step_s);
  summary.output_s = m_output_s;
  summary.wall_s = m_wall_before_s + seconds_since(m_begin);
  summary.run.wall_s = summary.wall_s;
  summary.peak_memory_bytes = peak_memory_bytes();
  for (const SimulatedBody& body : m_bodies) {
    const std::string solver = body.solver();
    if (summary.solver.find(solver) != std::string::npos) continue;
    if (!summary.solver.empty()) summary.solver += "; ";
    summary.solver += solver;
  }
  detail::StateWriter state;
  for (const SimulatedBody& body : m_bodies) {
    state.write(body.state().u);
    state.write(body.state().v);
  }
  summary.state_sha256 = sha256_of_text(state.bytes());
  summary.remainder_rel =
      m_largest_energy_j > 0.0 ? m_largest_remainder_j / m_largest_energy_j : 0.0;
  return summary;
}

}  // namespace

void SceneOptions::check() const {
  if (folder.empty()) throw InputError("folder is empty, must be where the results go");
  constexpr int kMostThreads = 1024;
  if (threads < 0 || threads > kMostThreads)
    throw InputError(
        fmt::format("threads is {}, must be 0 (as the machine permits) to 1024", threads));
}

SceneSummary run_scene(const Scene& scene, const SceneOptions& options) {
  options.check();
  fix_threads(options.threads);
  make_folder(options.folder);
  SceneRun run(scene, options);
  const SceneSummary summary = run.finish();
  write_file_atomically(options.folder / "summary.json", summary_to_json(scene, summary));
  return summary;
}

}  // namespace twang
