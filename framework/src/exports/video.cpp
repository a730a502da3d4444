#include "exports/video.hpp"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <stdexcept>
#include <string>
#include <vector>

#include "config/errors.hpp"
#include "exports/browser.hpp"
#include "util/numbers.hpp"
#include "util/pipe.hpp"
#include "util/started_program.hpp"

namespace gripline::exports {
namespace {

namespace fs = std::filesystem;

/// ffmpeg, which takes pictures on its standard input.
class Encoder {
 public:
  Encoder(const fs::path& file, int fps)
      : program_(words(file, fps), {.handles = {{STDIN_FILENO, pictures_.read.number()}}}) {
    pictures_.read.close();
  }

  void add(const std::string& picture) {
    for (std::size_t done = 0; done < picture.size();) {
      const ssize_t n = ::write(pictures_.write.number(), picture.data() + done, picture.size() - done);
      if (n < 0 && errno == EINTR) continue;
      if (n <= 0) throw std::runtime_error("ffmpeg ended early");
      done += static_cast<std::size_t>(n);
    }
  }
  void finish() {
    pictures_.write.close();
    if (program_.exit_code() != 0) throw std::runtime_error("ffmpeg could not write the video");
  }

 private:
  static std::vector<std::string> words(const fs::path& file, int fps) {
    std::vector<std::string> all = {find_program("ffmpeg"), "-y", "-loglevel", "error"};
    for (const char* word : {"-f", "image2pipe", "-framerate"}) all.emplace_back(word);
    all.push_back(std::to_string(fps));
    for (const char* word : {"-c:v", "mjpeg", "-i", "-", "-c:v", "libx264", "-pix_fmt", "yuv420p", "-crf", "20",
                             "-movflags", "+faststart", "-f", "mp4"})
      all.emplace_back(word);
    all.push_back(file.string());
    return all;
  }

  Pipe pictures_;
  StartedProgram program_;
};

/// A pipe whose reader ended must be an error here and not the end of this process.
class NoPipeSignal {
 public:
  NoPipeSignal() : before_(std::signal(SIGPIPE, SIG_IGN)) {}
  ~NoPipeSignal() { std::signal(SIGPIPE, before_); }
  NoPipeSignal(const NoPipeSignal&) = delete;
  NoPipeSignal& operator=(const NoPipeSignal&) = delete;

 private:
  void (*before_)(int);
};

void check(const VideoOptions& o) {
  if (o.width < 160 || o.height < 120 || o.width > 7680 || o.height > 4320 || o.width % 2 != 0 || o.height % 2 != 0)
    throw InputError("a video is 160x120 to 7680x4320 pixels large, both even; found " + std::to_string(o.width) + "x" +
                     std::to_string(o.height));
  if (o.fps < 1 || o.fps > 120)
    throw InputError("a video has 1 to 120 pictures a second; found " + std::to_string(o.fps));
  if (!(o.rate > 0 && o.rate <= 100)) throw InputError("a video runs at 0 to 100 times the race's speed");
}

}  // namespace

void require_video_programs() {
  if (find_chromium().empty())
    throw InputError(
        "a video needs Chromium, which is not on the PATH: apt-get install chromium, or name it in GRIPLINE_CHROMIUM");
  if (find_program("ffmpeg").empty())
    throw InputError("a video needs ffmpeg, which is not on the PATH: apt-get install ffmpeg");
}

void write_video(const fs::path& page, const fs::path& file, const VideoOptions& options,
                 const std::function<void(std::size_t, std::size_t)>& progress) {
  check(options);
  require_video_programs();
  const NoPipeSignal ignored;
  Browser browser(find_chromium(), options.width, options.height);
  browser.open(page, "performance.getEntriesByName('gripline-built').length > 0");
  if (browser.evaluate("Boolean(window.gripline && window.gripline.replay)") != true)
    throw InputError(page.string() + ": nothing moves in it; a video is of the replay of a race");
  browser.evaluate(options.follow ? "gripline.replay.film(true)" : "gripline.replay.film(false)");
  const double end = browser.evaluate("gripline.state.clock.end").get<double>();
  const double to = options.to < options.from ? end : std::min(options.to, end);
  if (options.from < 0 || options.from >= to)
    throw InputError(format("the race lasts %f s; there is nothing to film from %f s on", end, options.from));
  const double step = options.rate / options.fps;
  const auto count = static_cast<std::size_t>(std::floor((to - options.from) / step + 1e-9)) + 1;
  const fs::path aside = file.string() + ".partial";
  try {
    Encoder encoder(aside, options.fps);
    for (std::size_t i = 0; i < count; ++i) {
      // After the second frame what was asked for has been painted.
      browser.evaluate(format("gripline.state.clock.seek(%f), ", options.from + static_cast<double>(i) * step) +
                       "new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done(true))))");
      encoder.add(browser.screenshot());
      if (progress) progress(i + 1, count);
    }
    encoder.finish();
  } catch (...) {
    std::error_code failed;
    fs::remove(aside, failed);
    throw;
  }
  fs::rename(aside, file);
}

}  // namespace gripline::exports
