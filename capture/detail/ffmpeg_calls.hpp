// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/avutil.h>
#include <libavutil/cpu.h>
#include <libavutil/imgutils.h>
#include <libavutil/opt.h>
#include <libavutil/pixdesc.h>
}

/// FFmpeg's functions by their own names, loaded when the first of them is called: with a hundred
/// codecs behind them the libraries take longer to load than what has no film takes to run.
namespace twang {
namespace detail {

/// The address of a function of FFmpeg, of the version of the headers.
/// @throws std::runtime_error if the library is not there
[[nodiscard]] void* find_in_ffmpeg(const char* name);

template <class Signature>
class FfmpegCall;

template <class Result, class... Arguments>
class FfmpegCall<Result(Arguments...)> {
 public:
  constexpr explicit FfmpegCall(const char* name) : m_name(name) {}
  Result operator()(Arguments... arguments) const {
    return reinterpret_cast<Result (*)(Arguments...)>(find_in_ffmpeg(m_name))(arguments...);
  }

 private:
  const char* m_name;
};

}  // namespace detail

// An object of the same name is found before FFmpeg's function is looked for. A signature's
// attributes (use the result) say nothing about its type.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wignored-attributes"
#define TWANG_FFMPEG_CALL(name) inline constexpr detail::FfmpegCall<decltype(::name)> name(#name)
TWANG_FFMPEG_CALL(av_d2q);
TWANG_FFMPEG_CALL(av_dict_free);
TWANG_FFMPEG_CALL(av_dict_get);
TWANG_FFMPEG_CALL(av_dict_set);
TWANG_FFMPEG_CALL(av_find_best_stream);
TWANG_FFMPEG_CALL(av_frame_alloc);
TWANG_FFMPEG_CALL(av_frame_free);
TWANG_FFMPEG_CALL(av_frame_get_buffer);
TWANG_FFMPEG_CALL(av_frame_make_writable);
TWANG_FFMPEG_CALL(av_get_cpu_flags);
TWANG_FFMPEG_CALL(av_get_picture_type_char);
TWANG_FFMPEG_CALL(av_get_pix_fmt_name);
TWANG_FFMPEG_CALL(av_guess_sample_aspect_ratio);
TWANG_FFMPEG_CALL(av_interleaved_write_frame);
TWANG_FFMPEG_CALL(av_log_set_level);
TWANG_FFMPEG_CALL(av_opt_set);
TWANG_FFMPEG_CALL(av_opt_set_double);
TWANG_FFMPEG_CALL(av_opt_set_int);
TWANG_FFMPEG_CALL(av_packet_alloc);
TWANG_FFMPEG_CALL(av_packet_free);
TWANG_FFMPEG_CALL(av_packet_rescale_ts);
TWANG_FFMPEG_CALL(av_packet_unref);
TWANG_FFMPEG_CALL(av_pix_fmt_desc_get);
TWANG_FFMPEG_CALL(av_read_frame);
TWANG_FFMPEG_CALL(av_stream_get_side_data);
TWANG_FFMPEG_CALL(av_strerror);
TWANG_FFMPEG_CALL(av_write_trailer);
TWANG_FFMPEG_CALL(avcodec_alloc_context3);
TWANG_FFMPEG_CALL(avcodec_find_decoder);
TWANG_FFMPEG_CALL(avcodec_find_encoder);
TWANG_FFMPEG_CALL(avcodec_find_encoder_by_name);
TWANG_FFMPEG_CALL(avcodec_free_context);
TWANG_FFMPEG_CALL(avcodec_get_name);
TWANG_FFMPEG_CALL(avcodec_open2);
TWANG_FFMPEG_CALL(avcodec_parameters_from_context);
TWANG_FFMPEG_CALL(avcodec_parameters_to_context);
TWANG_FFMPEG_CALL(avcodec_receive_frame);
TWANG_FFMPEG_CALL(avcodec_receive_packet);
TWANG_FFMPEG_CALL(avcodec_send_frame);
TWANG_FFMPEG_CALL(avcodec_send_packet);
TWANG_FFMPEG_CALL(avformat_alloc_output_context2);
TWANG_FFMPEG_CALL(avformat_close_input);
TWANG_FFMPEG_CALL(avformat_find_stream_info);
TWANG_FFMPEG_CALL(avformat_free_context);
TWANG_FFMPEG_CALL(avformat_index_get_entries_count);
TWANG_FFMPEG_CALL(avformat_index_get_entry);
TWANG_FFMPEG_CALL(avformat_new_stream);
TWANG_FFMPEG_CALL(avformat_open_input);
TWANG_FFMPEG_CALL(avformat_write_header);
TWANG_FFMPEG_CALL(avio_closep);
TWANG_FFMPEG_CALL(avio_flush);
TWANG_FFMPEG_CALL(avio_open);
TWANG_FFMPEG_CALL(avio_size);
#undef TWANG_FFMPEG_CALL
#pragma GCC diagnostic pop

}  // namespace twang
