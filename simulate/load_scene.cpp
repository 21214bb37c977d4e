// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "core/sha256.hpp"
#include "core/units.hpp"
#include "rigs/toml_table.hpp"
#include "simulate/detail/scene_tables.hpp"
#include "simulate/scene.hpp"

#include <fmt/format.h>

namespace twang {
namespace {

constexpr const char* kFormat = "twang-scene/1";

SceneOutput read_output(const TomlTable& document, double step_s) {
  SceneOutput output;
  const auto table = document.table("output");
  if (!table) return output;
  table->allow_only({"every_s", "vtu", "checkpoint_every_s"});
  const auto interval = [&](std::string_view key) -> std::optional<double> {
    if (!table->has(key)) return std::nullopt;
    const double value = table->positive(key);
    constexpr double kSlack = 1.0 - 1e-9;  // round-off of what was typed
    if (value < kSlack * step_s) table->refuse(key, fmt::format("at least step_s, {}", step_s));
    return value;
  };
  output.every_s = interval("every_s");
  output.checkpoint_every_s = interval("checkpoint_every_s");
  if (table->has("vtu")) output.vtu = table->flag("vtu");
  return output;
}

void read_time(const TomlTable& document, Scene& scene) {
  scene.duration_s = document.positive("duration_s");
  scene.step_s = document.positive("step_s");
  if (scene.step_s > scene.duration_s)
    document.refuse("step_s", fmt::format("at most duration_s, {}", scene.duration_s));
  constexpr double kMostSteps = 2e9;
  if (scene.duration_s / scene.step_s >= kMostSteps)
    document.refuse("step_s", "large enough for fewer than 2e9 steps");
  if (document.has("gravity_m_s2")) scene.gravity_m_s2 = document.vector("gravity_m_s2");
  if (document.has("integrator")) {
    scene.scheme = static_cast<Scheme>(document.choice(
        "integrator", {"newmark", "implicit_euler", "bdf2", "linearly_implicit_newmark"}));
  }
}

/// Of the scene's text and of all files it names.
std::string fingerprint(const std::string& content, const Scene& scene) {
  std::string all = sha256_of_text(content);
  for (const SceneBody& body : scene.bodies) {
    all += body.rig.sha256;
    for (const PartSolid& solid : body.rig.parts) {
      if (const auto* surface = std::get_if<SurfaceFile>(&solid.shape))
        all += sha256_of_file(surface->file);
    }
    if (body.rig.meshing.file) all += sha256_of_file(body.rig.meshing.file->file);
    if (body.material_file) all += sha256_of_file(body.material_file->path);
  }
  for (const SceneBaseMotion& motion : scene.base_motions) {
    for (Eigen::Index i = 0; i < motion.displacement.size(); ++i)
      all += fmt::format("{:a} ", motion.displacement.data()[i]);
    for (const double time : motion.time_s) all += fmt::format("{:a} ", time);
  }
  return sha256_of_text(all);
}

}  // namespace

Scene parse_scene(const std::string& content, const std::filesystem::path& file) {
  const TomlDocument parsed(content, file.string(), fmt::format("a scene file ({})", kFormat));
  const TomlTable document = parsed.root();
  if (document.has("format") && document.text("format") != kFormat)
    document.refuse("format", fmt::format("\"{}\"", kFormat));
  document.allow_only({"format",
                       "name",
                       "duration_s",
                       "step_s",
                       "gravity_m_s2",
                       "integrator",
                       "body",
                       "load",
                       "probe",
                       "base_motion",
                       "output"});
  (void)document.text("format");
  if (document.has("name")) (void)document.text("name");
  const std::filesystem::path folder = file.parent_path();
  Scene scene;
  scene.file = file;
  read_time(document, scene);
  scene.bodies = detail::read_bodies(document, folder);
  scene.loads = detail::read_loads(document, scene);
  scene.probes = detail::read_probes(document, scene);
  scene.base_motions = detail::read_base_motions(document, scene, folder);
  scene.output = read_output(document, scene.step_s);
  scene.sha256 = fingerprint(content, scene);
  return scene;
}

Scene load_scene(const std::filesystem::path& path) { return parse_scene(read_file(path), path); }

}  // namespace twang
