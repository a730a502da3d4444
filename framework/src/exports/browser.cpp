#include "exports/browser.hpp"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <stdexcept>
#include <thread>
#include <vector>

namespace gripline::exports {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr int timeout_ms = 60'000;  // of one answer

[[noreturn]] void fail(const std::string& what) { throw std::runtime_error("the browser " + what); }

/// RFC 4648; what is no digit of it is skipped.
std::string decoded(std::string_view text) {
  std::string bytes;
  std::uint32_t word = 0;
  int bits = 0;
  for (const char c : text) {
    int digit = -1;
    if (c >= 'A' && c <= 'Z') digit = c - 'A';
    if (c >= 'a' && c <= 'z') digit = c - 'a' + 26;
    if (c >= '0' && c <= '9') digit = c - '0' + 52;
    if (c == '+') digit = 62;
    if (c == '/') digit = 63;
    if (digit < 0) continue;
    word = word << 6 | static_cast<std::uint32_t>(digit);
    bits += 6;
    if (bits >= 8) bytes += static_cast<char>(word >> (bits -= 8) & 0xff);
  }
  return bytes;
}

}  // namespace

std::string find_program(const char* name) {
  const char* path = std::getenv("PATH");
  std::string rest = path != nullptr ? path : "";
  while (!rest.empty()) {
    const std::size_t colon = rest.find(':');
    const fs::path file = fs::path(rest.substr(0, colon)) / name;
    if (access(file.c_str(), X_OK) == 0 && fs::is_regular_file(file)) return file.string();
    rest = colon == rest.npos ? "" : rest.substr(colon + 1);
  }
  return "";
}

std::string find_chromium() {
  if (const char* named = std::getenv("GRIPLINE_CHROMIUM"); named != nullptr && *named != '\0') return named;
  for (const char* name : {"chromium", "chromium-browser", "google-chrome", "google-chrome-stable"})
    if (std::string found = find_program(name); !found.empty()) return found;
  return "";
}

Browser::Browser(const std::string& chromium, int width, int height) {
  std::vector<std::string> words = {fs::absolute(chromium).string(),
                                    "--headless=new",
                                    "--remote-debugging-pipe",
                                    "--disable-gpu",
                                    "--hide-scrollbars",
                                    "--no-first-run",
                                    "--user-data-dir=" + profile_.path().string(),
                                    "--window-size=" + std::to_string(width) + "," + std::to_string(height)};
  if (geteuid() == 0) words.emplace_back("--no-sandbox");  // with a sandbox it refuses to run as root
  words.emplace_back("about:blank");
  const Handle nothing(::open("/dev/null", O_RDWR | O_CLOEXEC));
  // It reads commands from handle 3 and answers on handle 4.
  program_.emplace(words, StartedProgram::Setup{.handles = {{STDIN_FILENO, nothing.number()},
                                                            {STDOUT_FILENO, nothing.number()},
                                                            {STDERR_FILENO, nothing.number()},
                                                            {3, commands_.read.number()},
                                                            {4, answers_.write.number()}},
                                                .own_group = true});
  commands_.read.close();
  answers_.write.close();
  const json target = call("Target.createTarget", {{"url", "about:blank"}});
  session_ = call("Target.attachToTarget", {{"targetId", target.at("targetId")}, {"flatten", true}}).at("sessionId");
  call("Emulation.setDeviceMetricsOverride",
       {{"width", width}, {"height", height}, {"deviceScaleFactor", 1}, {"mobile", false}});
}

void Browser::open(const fs::path& page, const std::string& ready) {
  call("Page.navigate", {{"url", "file://" + fs::absolute(page).string()}});
  const auto until = std::chrono::steady_clock::now() + std::chrono::milliseconds(timeout_ms);
  while (std::chrono::steady_clock::now() < until) {
    try {
      if (evaluate(ready) == true) return;
    } catch (const std::runtime_error&) {
      // The previous page is unloaded and this one is not loaded yet.
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  fail("did not draw " + page.string() + " within " + std::to_string(timeout_ms / 1000) + " s");
}

json Browser::evaluate(const std::string& expression) {
  const json answer =
      call("Runtime.evaluate", {{"expression", expression}, {"awaitPromise", true}, {"returnByValue", true}});
  if (answer.contains("exceptionDetails")) fail("says: " + answer["exceptionDetails"].value("text", std::string()));
  return answer.at("result").value("value", json());
}

std::string Browser::screenshot() {
  return decoded(call("Page.captureScreenshot", {{"format", "jpeg"}, {"quality", 92}}).at("data").get<std::string>());
}

json Browser::call(const std::string& method, const json& parameters) {
  json command = {{"id", ++id_}, {"method", method}, {"params", parameters}};
  if (!session_.empty()) command["sessionId"] = session_;
  std::string text = command.dump();
  text += '\0';
  for (std::size_t done = 0; done < text.size();) {
    const ssize_t n = ::write(commands_.write.number(), text.data() + done, text.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) fail("ended before its time");
    done += static_cast<std::size_t>(n);
  }
  while (true) {
    const json answer = json::parse(read_message());
    if (answer.value("id", 0) != id_) continue;  // an event
    if (answer.contains("error")) fail("says: " + answer["error"].value("message", std::string()));
    return answer.at("result");
  }
}

std::string Browser::read_message() {
  while (true) {
    if (const std::size_t end = buffer_.find('\0'); end != buffer_.npos) {
      std::string message = buffer_.substr(0, end);
      buffer_.erase(0, end + 1);
      return message;
    }
    pollfd waiting = {answers_.read.number(), POLLIN, 0};
    const int there = poll(&waiting, 1, timeout_ms);
    if (there < 0 && errno == EINTR) continue;
    if (there == 0) fail("did not answer within " + std::to_string(timeout_ms / 1000) + " s");
    std::array<char, 65536> bytes{};
    const ssize_t n = ::read(answers_.read.number(), bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) fail("ended before its time");
    buffer_.append(bytes.data(), static_cast<std::size_t>(n));
  }
}

}  // namespace gripline::exports
