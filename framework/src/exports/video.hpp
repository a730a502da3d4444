// The replay of a report as a video: the page in a browser without a window, its pictures into ffmpeg.
#pragma once

#include <filesystem>
#include <functional>

namespace gripline::exports {

struct VideoOptions {
  int width = 1280, height = 720;  ///< [px], even
  int fps = 25;                    ///< pictures a second
  double rate = 1;                 ///< seconds of the race in a second of the video
  double from = 0, to = -1;        ///< [s] of the race; to < from: until its end
  bool follow = false;             ///< the car that the page follows, close by
};

/// Throws InputError with the missing program's name if Chromium or ffmpeg is not installed. Ask before long work.
void require_video_programs();

/// Films the page that `report` wrote. The file is renamed to its name when it is complete. `progress(done, total)` is
/// called after each picture. Throws InputError, std::runtime_error.
void write_video(const std::filesystem::path& page, const std::filesystem::path& file, const VideoOptions& options,
                 const std::function<void(std::size_t, std::size_t)>& progress);

}  // namespace gripline::exports
