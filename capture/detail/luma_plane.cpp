// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/luma_plane.hpp"

#include <algorithm>
#include <cstddef>

extern "C" {
#include <libavutil/display.h>
}

namespace twang::detail {
namespace {

constexpr int kBitsOut = 8;
constexpr int kMaxBits = 16;

/// The luma samples of a picture format.
const AVComponentDescriptor& luma_of(int pixel_format) {
  return av_pix_fmt_desc_get(static_cast<AVPixelFormat>(pixel_format))->comp[0];
}

bool is_big_endian(int pixel_format) {
  const auto* format = av_pix_fmt_desc_get(static_cast<AVPixelFormat>(pixel_format));
  return (format->flags & AV_PIX_FMT_FLAG_BE) != 0;
}

}  // namespace

int Orientation::turn_deg() const {
  // Clockwise, what was on the left comes to the top, then to the right.
  if (right[0] == 1) return 0;
  if (right[0] == -1) return 180;
  return down[0] == 1 ? 90 : 270;
}

Orientation orientation_of(const AVStream& stream) {
  std::size_t size = 0;
  const std::uint8_t* data = av_stream_get_side_data(&stream, AV_PKT_DATA_DISPLAYMATRIX, &size);
  if (!data || size < 9 * sizeof(std::int32_t)) return {};
  // Shown (x, y) = stored (x, y) times [[a, b], [c, d]], 16.16 fixed point; rows of the matrix are
  // three numbers long.
  const auto* matrix = reinterpret_cast<const std::int32_t*>(data);
  const auto sign = [](std::int32_t value) { return (value > 0) - (value < 0); };
  Orientation asked;
  asked.right = {sign(matrix[0]), sign(matrix[3])};
  asked.down = {sign(matrix[1]), sign(matrix[4])};
  const auto is_axis = [](const std::array<int, 2>& v) { return (v[0] != 0) != (v[1] != 0); };
  const bool quarter =
      is_axis(asked.right) && is_axis(asked.down) && (asked.right[0] == 0) != (asked.down[0] == 0);
  return quarter ? asked : Orientation{};
}

bool has_luma(int pixel_format) {
  const auto* format = av_pix_fmt_desc_get(static_cast<AVPixelFormat>(pixel_format));
  if (!format || format->nb_components < 1) return false;
  constexpr std::uint64_t kNoLuma = AV_PIX_FMT_FLAG_RGB | AV_PIX_FMT_FLAG_PAL |
                                    AV_PIX_FMT_FLAG_HWACCEL | AV_PIX_FMT_FLAG_BITSTREAM |
                                    AV_PIX_FMT_FLAG_BAYER | AV_PIX_FMT_FLAG_FLOAT;
  const AVComponentDescriptor& luma = format->comp[0];
  return (format->flags & kNoLuma) == 0 && luma.plane == 0 && luma.depth >= kBitsOut &&
         luma.depth <= kMaxBits;
}

LumaFrame LumaPlane::view(const AVFrame& picture) {
  const AVComponentDescriptor& luma = luma_of(picture.format);
  LumaFrame stored{picture.data[0], picture.linesize[0], picture.width, picture.height, 0.0};
  if (luma.depth != kBitsOut || luma.step != 1) {
    unpack(picture);
    stored.pixels = m_unpacked.data();
    stored.stride = picture.width;
  }
  if (m_orientation.upright()) return stored;
  turn(stored);
  const bool swap = m_orientation.swaps_sides();
  const int width = swap ? stored.height_px : stored.width_px;
  const int height = swap ? stored.width_px : stored.height_px;
  return {m_turned.data(), width, width, height, 0.0};
}

/// Samples of more than 8 bits, or interleaved with chroma.
void LumaPlane::unpack(const AVFrame& picture) {
  const AVComponentDescriptor& luma = luma_of(picture.format);
  const auto width = static_cast<std::size_t>(picture.width);
  m_unpacked.resize(width * static_cast<std::size_t>(picture.height));
  const int surplus = luma.depth - kBitsOut;
  const unsigned half = surplus > 0 ? 1U << (surplus - 1) : 0U;
  const unsigned mask = (1U << luma.depth) - 1U;
  const bool big = is_big_endian(picture.format);
  const bool wide = luma.depth + luma.shift > kBitsOut;
  for (int y = 0; y < picture.height; ++y) {
    const std::uint8_t* from =
        picture.data[0] + static_cast<std::ptrdiff_t>(y) * picture.linesize[0] + luma.offset;
    std::uint8_t* to = m_unpacked.data() + static_cast<std::size_t>(y) * width;
    for (std::size_t x = 0; x < width; ++x, from += luma.step) {
      unsigned sample = from[0];
      if (wide) {
        const unsigned second = from[1];
        sample = big ? sample << 8U | second : second << 8U | sample;
      }
      sample = (sample >> static_cast<unsigned>(luma.shift)) & mask;
      to[x] = static_cast<std::uint8_t>(std::min((sample + half) >> surplus, 255U));
    }
  }
}

void LumaPlane::turn(const LumaFrame& stored) {
  const bool swap = m_orientation.swaps_sides();
  const std::ptrdiff_t width = swap ? stored.height_px : stored.width_px;
  const std::ptrdiff_t height = swap ? stored.width_px : stored.height_px;
  m_turned.resize(static_cast<std::size_t>(width * height));
  // Where stored (0, 0) is shown, and how far a stored step right and down moves it.
  const auto [rx, ry] = m_orientation.right;
  const auto [dx, dy] = m_orientation.down;
  const std::ptrdiff_t x0 = rx + ry < 0 ? width - 1 : 0;
  const std::ptrdiff_t y0 = dx + dy < 0 ? height - 1 : 0;
  const std::ptrdiff_t step_x = rx + dx * width;
  const std::ptrdiff_t step_y = ry + dy * width;
  // Tiles, so that neither the read nor the written side leaves the cache.
  constexpr int kTile = 64;
  for (int top = 0; top < stored.height_px; top += kTile) {
    const int bottom = std::min(top + kTile, stored.height_px);
    for (int left = 0; left < stored.width_px; left += kTile) {
      const int end = std::min(left + kTile, stored.width_px);
      for (int y = top; y < bottom; ++y) {
        const std::uint8_t* from = stored.pixels + y * stored.stride;
        std::uint8_t* to = m_turned.data() + y0 * width + x0 + y * step_y;
        for (int x = left; x < end; ++x) to[x * step_x] = from[x];
      }
    }
  }
}

}  // namespace twang::detail
