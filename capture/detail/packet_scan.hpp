// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/detail/ffmpeg.hpp"

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace twang::detail {

/// A film opened for demuxing: its container and the stream that holds the pictures.
struct OpenedFilm {
  InputPtr container;
  AVStream* stream = nullptr;
};

/// Opens a film's container.
/// @throws InputError naming the file if it is missing, no regular file, empty, no film or without
/// pictures
[[nodiscard]] OpenedFilm open_film(const std::filesystem::path& path);

/// What one reading of all packets, without decoding, says of a film.
struct PacketScan {
  struct Stamp {
    std::int64_t ticks = AV_NOPTS_VALUE;  ///< presentation stamp
    bool discarded = false;               ///< cut away by the container's edit list
  };
  std::vector<Stamp> stamps;     ///< of the picture packets, ascending
  bool reordering_lost = false;  ///< every packet is stamped as if pictures were shown in the order
                                 ///< of decoding
  std::string broken;            ///< why the file is not whole; empty if it is

  [[nodiscard]] long num_shown() const;  ///< packets that are not discarded
};

/// Reads all packets of a film once. Cost: one pass over the file.
[[nodiscard]] PacketScan scan_packets(const std::filesystem::path& path);

}  // namespace twang::detail
