#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <mutex>
#include <string>
#include <system_error>
#include <thread>

#include <fmt/format.h>
#include <httplib.h>

#include "app/command/command_line.h"
#include "app/command/result.h"
#include "app/command/stop_signals.h"
#include "app/output/report.h"
#include "renderer/core/error.h"

namespace pathfit::app::serve_command {
namespace {

namespace fs = std::filesystem;

constexpr const char* kHost = "127.0.0.1";
constexpr int kNumThreads = 4;
constexpr int kMaxPort = 65535;
constexpr auto kPause = std::chrono::milliseconds(50);

/// What the page shows, made anew when a file of the run has changed.
class RunNews {
 public:
  explicit RunNews(const RunDirectory& run) : run_(run) {}

  struct Data {
    std::string version;  ///< another one for other data
    Json json;
  };
  /// From any thread. Throws IoError.
  Data Newest() {
    const std::lock_guard lock(mutex_);
    const std::string version = Version();
    if (version != data_.version) data_ = {version, ReportJson(LoadReportData(run_), {})};
    return data_;
  }

 private:
  [[nodiscard]] std::string Version() const {
    // A process that was killed changes no file.
    std::string version = EffectiveStatus(ReadRunRecord(run_.Record()), run_.root());
    for (const fs::path& path : {run_.Record(), run_.History(), run_.Model(), run_.StartModel()}) {
      std::error_code error;
      const fs::file_time_type time = fs::last_write_time(path, error);
      version += error ? "-" : fmt::format("-{:x}", time.time_since_epoch().count());
    }
    return '"' + version + '"';
  }

  const RunDirectory& run_;
  std::mutex mutex_;
  Data data_;
};

/// A page of another site that has its own name point to this machine must not read the run.
bool IsLocal(std::string host) {
  host = host.substr(0, host.rfind(':'));
  return host == kHost || host == "localhost";
}

void Route(httplib::Server& server, RunNews& news) {
  server.set_default_headers({{"Cache-Control", "no-store"},
                              {"X-Content-Type-Options", "nosniff"},
                              {"Cross-Origin-Resource-Policy", "same-origin"}});
  server.set_pre_routing_handler([](const httplib::Request& request, httplib::Response& response) {
    if (IsLocal(request.get_header_value("Host"))) {
      return httplib::Server::HandlerResponse::Unhandled;
    }
    response.status = 403;
    response.set_content("pathfit serves this machine only\n", "text/plain");
    return httplib::Server::HandlerResponse::Handled;
  });
  server.set_exception_handler(
      [](const httplib::Request&, httplib::Response& response, const std::exception_ptr& thrown) {
        response.status = 500;
        try {
          std::rethrow_exception(thrown);
        } catch (const std::exception& e) {
          response.set_content(std::string(e.what()) + "\n", "text/plain; charset=utf-8");
        } catch (...) {
          response.set_content("internal error\n", "text/plain");
        }
      });
  server.Get("/", [&news](const httplib::Request&, httplib::Response& response) {
    response.set_content(LivePage(news.Newest().json), "text/html; charset=utf-8");
  });
  server.Get("/data.json", [&news](const httplib::Request& request, httplib::Response& response) {
    const RunNews::Data data = news.Newest();
    response.set_header("ETag", data.version);
    if (request.get_header_value("If-None-Match") == data.version) {
      response.status = 304;
    } else {
      response.set_content(JsonText(data.json, -1), "application/json");
    }
  });
}

/// Returns the port that it has now. Throws IoError.
int Bind(httplib::Server& server, int port) {
  server.set_address_family(AF_INET);
  // Not SO_REUSEPORT, with which two programs would share a port unnoticed.
  server.set_socket_options([](socket_t socket) {
    const int yes = 1;
    setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof(yes));
  });
  errno = 0;
  if (port == 0) {
    const int given = server.bind_to_any_port(kHost);
    if (given > 0) return given;
  } else if (server.bind_to_port(kHost, port)) {
    return port;
  }
  const int reason = errno;
  throw renderer::IoError(fmt::format("{}:{} cannot be served: {}; --port 0 takes one that is free",
                                      kHost,
                                      port,
                                      reason == EADDRINUSE
                                          ? "another program uses this port"
                                          : std::system_category().message(reason)));
}

struct Options {
  int port = 8321;  ///< 0: any
};

void Declare(OptionList& options, Options& own) {
  options.Whole("--port", "Port of 127.0.0.1; 0: any that is free", 0, kMaxPort, own.port);
}

constexpr ResultKey kResult[] = {
    {"run", "text", "The run directory"},
    {"url", "text", "Where its page is, until the command is stopped"}};

ExitStatus Run(CommandContext& context, const Options& own) {
  const RunDirectory run = OpenRunDirectory(context.line.target);
  RunNews news(run);
  (void)news.Newest();  // what cannot be read is said before anybody looks
  httplib::Server server;
  server.new_task_queue = [] { return new httplib::ThreadPool(kNumThreads); };
  // No connection keeps the end waiting.
  server.set_keep_alive_max_count(1);
  server.set_keep_alive_timeout(1);
  Route(server, news);
  const StopSignals signals;
  const std::string url = fmt::format("http://{}:{}/", kHost, Bind(server, own.port));
  std::thread listener([&server] { server.listen_after_bind(); });
  struct Ending {  // also if what follows throws
    httplib::Server& server;
    std::thread& listener;
    ~Ending() {
      server.stop();
      listener.join();
    }
  } const ending{server, listener};
  while (!server.is_running() && !signals.flag()) std::this_thread::sleep_for(kPause);
  if (context.line.json) {
    PrintResult(context, {{"run", run.root().string()}, {"url", url}});
  } else {
    fmt::print("{}\n", url);
  }
  std::fflush(stdout);
  context.log.Info("serving " + run.root().string() + " until Ctrl-C");
  while (!signals.flag() && server.is_running()) std::this_thread::sleep_for(kPause);
  return ExitStatus::kFinished;
}

}  // namespace

extern const Command kServeCommand = {
    "serve",
    "Shows the report of a run in a browser, and follows the run: on this machine only",
    "RUN",
    Prepare<Options, Declare, Run>,
    kResult};

}  // namespace pathfit::app::serve_command
