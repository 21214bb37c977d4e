// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/error.hpp"
#include "rigs/closed_surface.hpp"
#include "rigs/generators/paper_shapes.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <filesystem>

/// Writes the surfaces that the rigs in `rigs/` load into a folder.
int main(int argc, char** argv) {
  if (argc != 2) {
    fmt::print(stderr, "usage: twang_write_shapes FOLDER\n");
    return 2;
  }
  try {
    for (const auto& [name, surface] : twang::paper_shapes()) {
      const std::filesystem::path path = std::filesystem::path(argv[1]) / name;
      twang::write_stl(path, surface);
      twang::SurfaceFile file;
      file.file = path;
      const twang::ClosedSurface closed = twang::read_closed_surface(file);
      fmt::print("{}: {} triangles, {:.5g} mm³\n",
                 path.string(),
                 closed.mesh.triangles.cols(),
                 closed.volume_m3 * 1e9);
      for (const std::string& note : closed.notes) fmt::print("  {}\n", note);
    }
  } catch (const twang::InputError& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 2;
  }
  return 0;
}
