#include "client/render/gpu_timer.hpp"

namespace fracture::render {

void GpuTimer::begin() {
  running_ = next_ - oldest_ < kAtOnce;
  if (!running_) return;
  Query& query = queries_[next_ % kAtOnce];
  if (query.get() == 0) query = make_query();
  glBeginQuery(GL_TIME_ELAPSED, query.get());
}

void GpuTimer::end() {
  if (!running_) return;
  glEndQuery(GL_TIME_ELAPSED);
  running_ = false;
  ++next_;
}

std::optional<double> GpuTimer::take() {
  if (oldest_ == next_) return std::nullopt;
  const GLuint query = queries_[oldest_ % kAtOnce].get();
  GLint there = GL_FALSE;
  glGetQueryObjectiv(query, GL_QUERY_RESULT_AVAILABLE, &there);
  if (there == GL_FALSE) return std::nullopt;
  GLuint64 nanoseconds = 0;
  glGetQueryObjectui64v(query, GL_QUERY_RESULT, &nanoseconds);
  ++oldest_;
  return 1e-6 * static_cast<double>(nanoseconds);
}

}  // namespace fracture::render
