#include "cli/program.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <boost/program_options/errors.hpp>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <iostream>
#include <vector>

#include "cli/premature_end.hpp"
#include "config/errors.hpp"
#include "plugin/registry.hpp"
#include "util/made_folders.hpp"

namespace gripline::tools {
namespace {

int run_guarded(Arguments args, int (*body)(Arguments), const std::string& command) {
  try {
    return body(args);
  } catch (const InputError& e) {
    std::cerr << e.what() << '\n';
    return bad_input;
  } catch (const PluginError& e) {
    std::cerr << escape_control(e.what()) << '\n';
    return plugin_unusable;
  } catch (const boost::program_options::error& e) {
    std::cerr << e.what() << "; see " << command << (command.ends_with(' ') ? args[0] : "") << " --help\n";
    return bad_input;
  } catch (const std::bad_alloc&) {
    std::cerr << "gripline: out of memory\n";
    return run_broke;
  } catch (const std::exception& e) {
    std::cerr << "gripline: " << escape_control(e.what()) << '\n';
    return run_broke;
  }
}

/// The exit code once the output is written. A reader that went away (`| head`) is no error.
int after_output(int code) {
  errno = 0;
  std::cout.flush();
  const bool lost = !std::cout || std::ferror(stdout) != 0;
  struct stat where {};
  if (!lost || (fstat(STDOUT_FILENO, &where) == 0 && (S_ISFIFO(where.st_mode) || S_ISSOCK(where.st_mode)))) return code;
  // errno of the failed write may be lost: another write sets it again.
  if (errno == 0) (void)!write(STDOUT_FILENO, "\n", 1);
  std::cerr << "gripline: cannot write the output" << (errno != 0 ? std::string(": ") + std::strerror(errno) : "")
            << '\n';
  return code == good ? run_broke : code;
}

}  // namespace

int run_program(int argc, char** argv, int (*body)(Arguments), const std::string& command) {
  report_premature_end();
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);           // a file beyond the size limit is then an error of write()
  setenv("OPENBLAS_NUM_THREADS", "1", 0);  // read when Ipopt is loaded: a run is one thread, and the same bytes
  const std::vector<std::string> args(argv + 1, argv + argc);
  const int code = after_output(run_guarded(args, body, command));
  if (code != good) remove_empty_made_folders();
  expect_end();
  return code;
}

}  // namespace gripline::tools
