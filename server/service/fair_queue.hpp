// Start-time fair queueing (Goyal, Vin and Cheng, SIGCOMM 1996), in the form that the same authors gave it
// for processors, where what a task takes is known only when it has run (Goyal, Guo and Vin, "A hierarchical
// CPU scheduler for multimedia operating systems", OSDI 1996). Each flow (a name, an address) has a queue of
// its own, first come first served, and its first task a start tag
//
//     S = max(v, F)      v: the start tag of what was taken last (virtual time)
//                        F: the finish tag of the flow's task before, S + what that took / the flow's weight
//
// The task with the least start tag is served next. So among flows that always have work each gets its
// weight's share of the threads, whatever the others queue; one that was idle gets no credit for it, and one
// that has just come waits for at most one task of each other flow.
//
// Here F begins with the estimated cost and charge() corrects it by what was measured.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace fracture {

/// Whose turn a task takes.
struct Flow {
  std::string name{};
  double weight = 1;  ///< more than 0
};

/// Not thread-safe. Item has `std::uint64_t id`, which grows with the arrival, `double cost` in seconds and
/// `Flow flow`.
template <class Item>
class FairQueue {
 public:
  bool empty() const { return size_ == 0; }
  std::size_t size() const { return size_; }
  /// Flows with something queued.
  std::size_t busy_flows() const {
    std::size_t busy = 0;
    for (const auto& [name, state] : flows_) busy += !state.queue.empty();
    return busy;
  }
  std::size_t size_of(const std::string& flow) const {
    const auto at = flows_.find(flow);
    return at == flows_.end() ? 0 : at->second.queue.size();
  }

  /// Behind everything of its flow that came before it.
  void push(Item item) {
    State& state = flows_[item.flow.name];
    state.weight = item.flow.weight;
    if (state.queue.empty()) state.start = std::max(now_, state.finish);
    const auto behind = std::find_if(state.queue.begin(), state.queue.end(),
                                     [&](const Item& other) { return other.id > item.id; });
    state.queue.insert(behind, std::move(item));
    ++size_;
  }

  /// What goes next; null when there is nothing.
  const Item* front() const {
    const auto at = next(flows_);
    return at == flows_.end() ? nullptr : &at->second.queue.front();
  }
  Item pop() {
    State& state = next(flows_)->second;
    Item item = std::move(state.queue.front());
    state.queue.pop_front();
    --size_;
    now_ = std::max(now_, state.start);
    state.finish = state.start + item.cost / state.weight;
    state.start = state.finish;
    return item;
  }

  /// A task of this flow took so much more (less: negative) than its cost said; or work was done for it that
  /// was another flow's task.
  void charge(const Flow& flow, double seconds) {
    auto at = flows_.find(flow.name);
    if (at == flows_.end()) {
      if (seconds <= 0) return;
      at = flows_.emplace(flow.name, State{}).first;
    }
    State& state = at->second;
    state.weight = flow.weight;
    state.finish = std::max(now_, state.finish) + seconds / state.weight;
    state.start = std::max(now_, state.finish);
  }

  /// Takes a task out again; nothing when it is not here.
  std::optional<Item> remove(std::uint64_t id) {
    for (auto& [name, state] : flows_)
      for (auto at = state.queue.begin(); at != state.queue.end(); ++at)
        if (at->id == id) {
          Item item = std::move(*at);
          state.queue.erase(at);
          --size_;
          return item;
        }
    return std::nullopt;
  }

  /// How many would be served before each of these tasks if nothing came and costs were right; nothing for a task that
  /// is not here. All of them in two passes over the queue, because whoever asks holds a lock.
  std::vector<std::optional<std::size_t>> places(const std::vector<std::uint64_t>& ids) const {
    struct Wanted {
      Tag tag;
      std::size_t index;
      std::size_t before = 0;
    };
    std::vector<std::pair<std::uint64_t, std::size_t>> by_id;
    for (std::size_t k = 0; k < ids.size(); ++k) by_id.emplace_back(ids[k], k);
    std::sort(by_id.begin(), by_id.end());
    std::vector<Wanted> wanted;
    each_tag([&](const Tag& tag) {
      for (auto at = std::lower_bound(by_id.begin(), by_id.end(), std::pair(tag.second, std::size_t{0}));
           at != by_id.end() && at->first == tag.second; ++at)
        wanted.push_back({tag, at->second});
    });
    std::sort(wanted.begin(), wanted.end(), [](const Wanted& a, const Wanted& b) { return a.tag < b.tag; });
    if (!wanted.empty())
      each_tag([&](const Tag& tag) {
        const auto behind = std::upper_bound(wanted.begin(), wanted.end(), tag,
                                             [](const Tag& t, const Wanted& w) { return t < w.tag; });
        if (behind != wanted.end()) ++behind->before;
      });
    std::vector<std::optional<std::size_t>> places(ids.size());
    std::size_t before = 0;
    for (const Wanted& one : wanted) places[one.index] = before += one.before;
    return places;
  }

  /// The costs of what would be served before a new task of this flow.
  double ahead_of(const Flow& flow) const {
    double own = 0, ahead = 0, start = now_;
    if (const auto at = flows_.find(flow.name); at != flows_.end()) {
      for (const Item& item : at->second.queue) own += item.cost;
      start = std::max(now_, at->second.queue.empty() ? at->second.finish : at->second.start);
    }
    start += own / flow.weight;
    for (const auto& [name, state] : flows_) {
      if (name == flow.name) continue;
      double theirs = state.start;
      for (auto item = state.queue.begin(); item != state.queue.end() && theirs <= start; ++item) {
        ahead += item->cost;
        theirs += item->cost / state.weight;
      }
    }
    return own + ahead;
  }
  /// The costs of all that is queued.
  double cost() const {
    double sum = 0;
    for (const auto& [name, state] : flows_)
      for (const Item& item : state.queue) sum += item.cost;
    return sum;
  }

  /// Everything that was queued is done: the end of a busy period, from which nothing is remembered.
  void idle() {
    if (size_ > 0) return;
    flows_.clear();
    now_ = 0;
  }
  /// Forgets flows that owe nothing, so that clients who came once leave nothing behind; and where more than
  /// `most` are left, what the others owe: tags of flows that came once each may all lie beyond v, for as long
  /// as there is no end of the busy period.
  void sweep(std::size_t most) {
    std::erase_if(flows_, [this](const auto& entry) {
      return entry.second.queue.empty() && entry.second.finish <= now_;
    });
    if (flows_.size() > most)
      std::erase_if(flows_, [](const auto& entry) { return entry.second.queue.empty(); });
  }
  std::size_t flows() const { return flows_.size(); }

 private:
  struct State {
    std::deque<Item> queue;
    double start = 0, finish = 0, weight = 1;
  };
  using Tag = std::pair<double, std::uint64_t>;  ///< start, id: the least is served next
  /// Of everything that is queued, as it would be served if nothing came and costs were right.
  template <class Use>
  void each_tag(Use use) const {
    for (const auto& [name, state] : flows_) {
      double start = state.start;
      for (const Item& item : state.queue) {
        use(Tag{start, item.id});
        start += item.cost / state.weight;
      }
    }
  }
  /// Ties go to who came first.
  template <class Flows>
  static auto next(Flows& flows) -> decltype(flows.begin()) {
    auto best = flows.end();
    for (auto at = flows.begin(); at != flows.end(); ++at)
      if (!at->second.queue.empty() &&
          (best == flows.end() || std::pair(at->second.start, at->second.queue.front().id) <
                                      std::pair(best->second.start, best->second.queue.front().id)))
        best = at;
    return best;
  }

  std::map<std::string, State> flows_;
  std::size_t size_ = 0;
  double now_ = 0;
};

}  // namespace fracture
