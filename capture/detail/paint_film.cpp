// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/paint_film.hpp"

#include "core/error.hpp"

#include <fmt/format.h>

namespace twang::detail {

void paint_film(const std::filesystem::path& video,
                const std::filesystem::path& painted,
                const FilmPainting& painting,
                const PaintFrame& paint,
                const ProgressCallback& progress) {
  constexpr int kGoodEnoughToLookAt = 23;
  VideoReader reader(video);
  const VideoInfo& info = reader.info();
  VideoWriter writer(painted,
                     info.width_px,
                     info.height_px,
                     {.fps = painting.fps, .crf = kGoodEnoughToLookAt, .quick = true});
  const bool all = painting.count == FilmPainting::kAll;
  const std::size_t end = all ? FilmPainting::kAll : painting.first + painting.count;
  const auto total = static_cast<double>(
      all ? static_cast<std::size_t>(info.declared_frames.value_or(0)) : painting.count);
  for (std::size_t n = 0; n < end; ++n) {
    const auto frame = reader.read();
    if (!frame && all) break;
    if (!frame)
      throw InputError(fmt::format(
          "{}: has {} frames, must have the {} that are drawn", video.string(), n, end));
    if (n < painting.first) continue;
    writer.write([&](const PicturePlanes& planes) {
      copy_grey(*frame, planes);
      Picture picture = picture_of(planes);
      paint(picture, *frame, n);
    });
    report_progress(progress,
                    {painting.stage, static_cast<double>(n - painting.first + 1), total, "frames"});
  }
  writer.finish();
}

}  // namespace twang::detail
