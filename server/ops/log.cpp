#include "server/ops/log.hpp"

#include <spdlog/async.h>
#include <spdlog/formatter.h>
#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <atomic>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <future>
#include <memory>
#include <thread>
#include <utility>

namespace fracture::ops {
namespace {

using nlohmann::ordered_json;

/// Maximum number of lines that wait for the logging thread.
constexpr std::size_t kQueue = 8192;
/// Marks a payload that is a JSON object.
constexpr char kStructured = '\x01';

std::atomic<LogFormat> format{LogFormat::kText};

std::string dump(const ordered_json& value) {
  return value.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::string utc(spdlog::log_clock::time_point when) {
  const auto since = std::chrono::duration_cast<std::chrono::milliseconds>(when.time_since_epoch()).count();
  const std::time_t seconds = since / 1000;
  std::tm tm{};
  gmtime_r(&seconds, &tm);
  char date[32], text[48];
  std::strftime(date, sizeof date, "%Y-%m-%dT%H:%M:%S", &tm);
  std::snprintf(text, sizeof text, "%s.%03dZ", date, static_cast<int>(since % 1000));
  return text;
}

class JsonFormatter final : public spdlog::formatter {
 public:
  void format(const spdlog::details::log_msg& msg, spdlog::memory_buf_t& out) override {
    const std::string_view payload(msg.payload.data(), msg.payload.size());
    const auto level = spdlog::level::to_string_view(msg.level);
    std::string line = "{\"time\":\"" + utc(msg.time) + "\",\"level\":\"";
    line.append(level.data(), level.size()).append("\",");
    if (payload.size() > 2 && payload[0] == kStructured)
      line.append(payload.substr(2)).append("\n");
    else
      line += "\"message\":" + dump(std::string(payload)) + "}\n";
    out.append(line.data(), line.data() + line.size());
  }
  std::unique_ptr<spdlog::formatter> clone() const override { return std::make_unique<JsonFormatter>(); }
};

/// Formats fields as name=value. Values other than single plain words are written as JSON.
std::string as_text(std::string_view event, const ordered_json& fields) {
  std::string line(event);
  for (const auto& [name, value] : fields.items()) {
    const std::string text = dump(value);
    const bool plain =
        value.is_string() && text.size() > 2 && text.find_first_of(" \\=") == std::string::npos;
    line += " " + name + "=" + (plain ? text.substr(1, text.size() - 2) : text);
  }
  return line;
}

void log(spdlog::level::level_enum level, std::string_view event, const ordered_json& fields) {
  if (!spdlog::should_log(level)) return;
  if (format == LogFormat::kText) {
    spdlog::log(level, "{}", as_text(event, fields));
    return;
  }
  ordered_json object = {{"event", event}};
  object.update(fields);
  spdlog::log(level, "{}{}", kStructured, dump(object));
}

double hundredths(double value) { return std::round(value * 100) / 100; }

/// Maximum logged bytes of a client's path and method. The longest known method has 7 bytes.
constexpr std::size_t kLongestPath = 200, kLongestMethod = 16;

/// Shortens the text and masks special characters, so that clients cannot add lines or long texts to the log.
std::string masked(const std::string& text, std::size_t most) {
  std::string plain = text.substr(0, most);
  for (char& c : plain)
    if (static_cast<unsigned char>(c) <= 0x20 || static_cast<unsigned char>(c) >= 0x7f) c = '?';
  return plain;
}

}  // namespace

void start_logging(LogFormat wanted, const std::string& level) {
  format = wanted;
  spdlog::init_thread_pool(kQueue, 1);
  using Factory = spdlog::async_factory_nonblock;  // when the queue is full, the oldest line is dropped
  const auto logger = wanted == LogFormat::kJson
                          ? Factory::create<spdlog::sinks::stderr_sink_mt>("fracture")
                          : Factory::create<spdlog::sinks::stderr_color_sink_mt>("fracture");
  if (wanted == LogFormat::kJson)
    logger->set_formatter(std::make_unique<JsonFormatter>());
  else
    logger->set_pattern("%Y-%m-%dT%H:%M:%S.%eZ %^%l%$ %v", spdlog::pattern_time_type::utc);
  spdlog::set_default_logger(logger);
  spdlog::set_level(spdlog::level::from_str(level));
}

bool stop_logging(std::chrono::milliseconds patience) {
  auto done = std::make_shared<std::promise<void>>();
  std::thread([done] {
    spdlog::shutdown();
    done->set_value();
  }).detach();
  return done->get_future().wait_for(patience) == std::future_status::ready;
}

std::uint64_t dropped_log_lines() {
  const auto pool = spdlog::thread_pool();
  return pool ? pool->overrun_counter() : 0;
}

void log_event(std::string_view event, const ordered_json& fields) {
  log(spdlog::level::info, event, fields);
}

void log_request(const RequestRecord& record) {
  const auto level = record.admin ? spdlog::level::debug : spdlog::level::info;
  if (!spdlog::should_log(level)) return;
  ordered_json fields = {{"id", record.id},
                         {"method", masked(record.method, kLongestMethod)},
                         {"path", masked(record.path, kLongestPath)},
                         {"route", record.route},
                         {"status", record.status},
                         {"in", record.bytes_in},
                         {"out", record.bytes_out},
                         {"ms", hundredths(record.milliseconds)}};
  if (record.queue_milliseconds >= 0) fields["queue_ms"] = hundredths(record.queue_milliseconds);
  if (!record.delivered) fields["delivered"] = false;
  const std::pair<const char*, const std::string*> optional[] = {
      {"cache", &record.cache},     {"mesh", &record.mesh},         {"client", &record.client},
      {"address", &record.address}, {"trace_id", &record.trace_id}, {"parent_id", &record.parent_id}};
  for (const auto& [name, value] : optional)
    if (!value->empty()) fields[name] = *value;
  log(level, "request", fields);
}

void log_audit(const RequestRecord& record) {
  ordered_json fields = {{"client", record.client},
                         {"method", masked(record.method, kLongestMethod)},
                         {"path", masked(record.path, kLongestPath)},
                         {"status", record.status},
                         {"in", record.bytes_in},
                         {"id", record.id},
                         {"address", record.address}};
  if (!record.mesh.empty()) fields["mesh"] = record.mesh;
  log(spdlog::level::info, "audit", fields);
}

}  // namespace fracture::ops
