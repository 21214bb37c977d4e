// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/image.hpp"

#include <cstdint>
#include <vector>

namespace twang {

/// An image as a PNG file's bytes (FFmpeg's encoder).
[[nodiscard]] std::vector<std::uint8_t> encode_png(const Image& image);

}  // namespace twang
