// SPDX-License-Identifier: GPL-3.0-or-later
// The tables [[load]], [[probe]] and [[base_motion]] of a scene file.
#include "core/text.hpp"
#include "core/trace_file.hpp"
#include "core/units.hpp"
#include "simulate/detail/scene_tables.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace twang::detail {
namespace {

std::size_t body_named(const TomlTable& table, const Scene& scene) {
  std::vector<std::string> names;
  for (const SceneBody& body : scene.bodies) names.push_back(body.name);
  return table.choice("body", names);
}

const Marker& marker_named(const TomlTable& table, const SceneBody& body) {
  std::vector<std::string> ids;
  for (const Marker& marker : body.rig.markers)
    if (!marker.fixed) ids.push_back(marker.id);
  if (ids.empty())
    table.refuse("marker", fmt::format("of the body \"{}\", whose rig has none", body.name));
  return *body.rig.find_marker(ids[table.choice("marker", ids)]);
}

SceneLoad read_load(const TomlTable& table, const Scene& scene) {
  table.allow_only(
      {"body", "at_mm", "marker", "displacement_mm", "force_n", "release_s", "ramp_s"});
  SceneLoad load;
  load.key = table.place("");
  load.body = body_named(table, scene);
  const SceneBody& body = scene.bodies[load.body];
  if (table.has("ramp_s")) load.ramp_s = table.non_negative("ramp_s");
  if (!body.clamped && load.ramp_s == 0.0)
    table.refuse("body",
                 "a clamped body, or ramp_s > 0: a free one that is loaded has no equilibrium to "
                 "start from");
  if (table.has("at_mm") == table.has("marker"))
    table.complain("", "must have exactly one of at_mm and marker");
  load.at = table.has("at_mm") ? Eigen::Vector3d(table.vector("at_mm") * kMetresPerMillimetre)
                               : marker_named(table, body).position;
  if (table.has("displacement_mm") == table.has("force_n"))
    table.complain("", "must have exactly one of displacement_mm and force_n");
  if (table.has("displacement_mm")) {
    if (!body.clamped) table.complain("displacement_mm", "is of a free body, must be force_n");
    load.displacement = table.direction("displacement_mm") * kMetresPerMillimetre;
  } else {
    load.force = table.direction("force_n");
  }
  if (table.has("release_s")) load.release_s = table.non_negative("release_s");
  if (load.ramp_s > 0.0) {
    constexpr double kFewestSteps = 2.0;  // to start and to stop
    if (load.ramp_s < kFewestSteps * scene.step_s)
      table.refuse("ramp_s",
                   fmt::format("0 or at least two steps, {}", kFewestSteps * scene.step_s));
    if (load.release_s < load.ramp_s)
      table.complain(table.has("release_s") ? "release_s" : "",
                     fmt::format("must have release_s at least ramp_s, {}", load.ramp_s));
  }
  return load;
}

Eigen::VectorXd column_of(const TomlTable& table,
                          std::string_view key,
                          const Trace& trace,
                          const std::string& file) {
  const std::string name = table.text(key);
  const Channel* channel = trace.find(name);
  if (channel == nullptr) {
    std::vector<std::string> names;
    for (const Channel& other : trace.channels) names.push_back(other.name);
    table.refuse(key, fmt::format("a column of {} (nearest: {})", file, nearest_word(name, names)));
  }
  Eigen::VectorXd values = Eigen::Map<const Eigen::VectorXd>(
      channel->values.data(), static_cast<Eigen::Index>(channel->values.size()));
  if (!values.allFinite()) table.refuse(key, "a column without gaps, a clamp is somewhere always");
  return (values.array() - values[0]).matrix() * kMetresPerMillimetre;
}

SceneBaseMotion read_base_motion(const TomlTable& table,
                                 const Scene& scene,
                                 const std::filesystem::path& folder) {
  table.allow_only({"body", "trace", "x_column", "y_column", "z_column"});
  SceneBaseMotion motion;
  motion.body = body_named(table, scene);
  if (!scene.bodies[motion.body].clamped)
    table.refuse("body", "a clamped body, a free one has no base");
  const std::filesystem::path file = folder / table.text("trace");
  const Trace trace = read_trace_csv(file);
  constexpr std::size_t kFewestSamples = 3;  // of a parabola, from which a velocity is taken
  if (trace.num_samples() < kFewestSamples)
    table.refuse("trace", fmt::format("a file of {} samples or more", kFewestSamples));
  motion.time_s = trace.time_s;
  motion.displacement.setZero(3, static_cast<Eigen::Index>(trace.num_samples()));
  constexpr std::array<std::string_view, 3> kKeys = {"x_column", "y_column", "z_column"};
  bool any = false;
  for (std::size_t i = 0; i < kKeys.size(); ++i) {
    if (!table.has(kKeys[i])) continue;
    any = true;
    motion.displacement.row(static_cast<Eigen::Index>(i)) =
        column_of(table, kKeys[i], trace, file.string()).transpose();
  }
  if (!any) table.complain("", "must have x_column, y_column or z_column");
  return motion;
}

}  // namespace

std::vector<SceneLoad> read_loads(const TomlTable& document, const Scene& scene) {
  std::vector<SceneLoad> loads;
  for (const TomlTable& table : document.tables("load")) {
    loads.push_back(read_load(table, scene));
  }
  return loads;
}

std::vector<SceneProbe> read_probes(const TomlTable& document, const Scene& scene) {
  std::vector<SceneProbe> probes;
  for (const TomlTable& table : document.tables("probe")) {
    table.allow_only({"body", "marker"});
    SceneProbe probe;
    probe.body = body_named(table, scene);
    probe.marker = marker_named(table, scene.bodies[probe.body]).id;
    for (const SceneProbe& other : probes)
      if (other.body == probe.body && other.marker == probe.marker)
        table.refuse("marker", "a marker that is not probed already");
    probes.push_back(std::move(probe));
  }
  return probes;
}

std::vector<SceneBaseMotion> read_base_motions(const TomlTable& document,
                                               const Scene& scene,
                                               const std::filesystem::path& folder) {
  std::vector<SceneBaseMotion> motions;
  for (const TomlTable& table : document.tables("base_motion")) {
    motions.push_back(read_base_motion(table, scene, folder));
    for (std::size_t i = 0; i + 1 < motions.size(); ++i)
      if (motions[i].body == motions.back().body)
        table.refuse("body", "a body that has no other base motion");
  }
  return motions;
}

}  // namespace twang::detail
