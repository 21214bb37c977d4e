// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/error.hpp"
#include "rigs/load_rig.hpp"

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

namespace {

void require(bool true_of_every_rig) {
  if (!true_of_every_rig) std::abort();
}

/// What the loader promises of a rig that it accepts.
void check(const twang::Rig& rig) {
  require(!rig.name.empty());
  for (const twang::RigMaterial& material : rig.materials) require(material.density_kg_m3 > 0.0);
  for (const twang::Marker& marker : rig.markers) {
    require(!marker.id.empty() && marker.size_m > 0.0 && marker.position.allFinite());
  }
  for (const twang::Box& clamp : rig.clamps)
    require(clamp.min.allFinite() && clamp.max.allFinite());
  if (rig.observable) {
    for (const std::string& id : rig.observable->markers) {
      bool known = false;
      for (const twang::Marker& marker : rig.markers) known = known || marker.id == id;
      require(known);
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  try {
    check(twang::parse_rig(text, "/nowhere/fuzz.toml"));
  } catch (const twang::InputError& error) {
    require(std::string(error.what()).find("fuzz.toml") != std::string::npos);
  }
  return 0;
}
