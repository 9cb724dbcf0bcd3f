// Decides which client's turn it is, by start-time fair queueing (Goyal, Vin and Cheng, SIGCOMM 1996). We use its form for
// processors, where the length of a task is known only after it has run (Goyal, Guo and Vin, "A hierarchical CPU scheduler
// for multimedia operating systems", OSDI 1996). Each client (a name, or an address) has one tag for all its tasks:
//
//     tag = processor seconds used for the client so far / the client's weight
//
// The client with the lowest tag is served next. So clients that always have work get processor time in proportion to their
// weights, whatever the others queue, run or call urgent.
//
// After a rest, a client's tag is at most kCredit below the lowest tag of the clients that computed in the meantime. (Linux's
// Completely Fair Scheduler treats sleepers in the same way.) So a client that asks for little goes before one that asks for
// much. No tag is more than kMostDebt above that lowest tag: a client that used otherwise idle processors owes the others
// no more than that.
//
// The urgency of a task counts as a lead in this order (Duda and Cheriton, "Borrowed-virtual-time scheduling", SOSP 1999).
// It decides between tasks of one client, and between clients that have used about the same time. But no client gets more
// processor time by calling its work urgent. A second of background work counts as kBackgroundCost seconds, so background
// work gets a fifth of the time if it competes with work that a client waits for.
#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <queue>
#include <string>
#include <utility>
#include <vector>

#include "server/tenants/account.hpp"

namespace fracture {

/// Classes of tasks, from the most urgent to the least urgent.
enum class Priority { kRealtime, kBatch, kBackground };
inline constexpr std::array kPriorities = {Priority::kRealtime, Priority::kBatch, Priority::kBackground};

/// The client whose turn a task takes.
struct Flow {
  std::string name{};
  double weight = 1;                            ///< must be positive
  std::shared_ptr<tenants::Account> account{};  ///< is charged for the time used; null: no account
};

/// Not thread-safe. Item has the members `std::uint64_t id`, which increases in the order of arrival, `double cost` in
/// seconds, `Flow flow`, and `arrival`, a time.
template <class Item>
class FairQueue {
 public:
  static constexpr double kCredit = 0.6, kMostDebt = 1;  // seconds
  /// Seconds by which each class is ahead of the next one. The value is small because each of many clients that return from
  /// a rest may be ahead of less urgent work by this much.
  static constexpr double kLead = 0.03;
  static constexpr double kBackgroundCost = 4;
  /// Within a client, a task is served before more urgent ones that arrived this much later.
  static constexpr std::chrono::milliseconds kAging{1000};

  /// Returns how many seconds a second of this class counts as.
  static constexpr double cost_of(Priority priority) {
    return priority == Priority::kBackground ? kBackgroundCost : 1;
  }

  struct Line {
    bool empty() const { return resumed.empty() && queue.empty(); }
    /// Returns whether a resumed task is next. Resumed and queued tasks take turns.
    bool resumed_is_next() const { return !resumed.empty() && (queue.empty() || !resumed_was_last); }
    double cost() const {
      double cost = 0;
      for (const auto* items : {&resumed, &queue})
        for (const Item& item : *items) cost += item.cost;
      return cost;
    }
    const Item& front() const { return resumed_is_next() ? resumed.front() : queue.front(); }

    bool resumed_was_last = false;
    std::deque<Item> resumed, queue;
  };
  struct Client {
    /// Returns the client's position for tasks of this class. The lowest key goes first.
    double key(Priority priority) const { return FairQueue::key(tag, priority); }
    bool rests() const {
      return running == 0 &&
             std::all_of(lines.begin(), lines.end(), [](const Line& line) { return line.empty(); });
    }
    Line& line(Priority priority) { return lines[static_cast<std::size_t>(priority)]; }
    const Line& line(Priority priority) const { return lines[static_cast<std::size_t>(priority)]; }

    std::string name;
    double weight = 1, tag = 0;
    std::size_t running = 0;  ///< number of tasks that were taken and have not ended
    std::array<Line, 3> lines;
  };
  struct Next {
    Client* client;
    Priority priority;
    double key() const { return client->key(priority); }
    const Item& item() const { return client->line(priority).front(); }
  };

  // -- queued tasks

  /// Queues a task behind all earlier ones of its client and class.
  void push(Priority priority, Item item) {
    Client& client = arrives(item.flow);
    insert(client.line(priority).queue, std::move(item));
  }
  /// Queues a task that continues earlier work. These tasks have a line of their own.
  void push_resumed(Priority priority, Item item) {
    Client& client = arrives(item.flow);
    insert(client.line(priority).resumed, std::move(item));
  }

  /// Returns the next task of each client, in the order of their turns. Leaves out clients without a task that may begin.
  template <class May>
  std::vector<Next> candidates(const May& may) {
    std::vector<Next> all;
    for (auto& [name, client] : clients_) {
      std::optional<Next> chosen;
      for (const Priority priority : kPriorities) {
        const Line& line = client.line(priority);
        if (line.empty() || !may(client, priority)) continue;
        if (!chosen || line.front().arrival + kAging < chosen->item().arrival)
          chosen = Next{&client, priority};
      }
      if (chosen) all.push_back(*chosen);
    }
    std::sort(all.begin(), all.end(), [](const Next& a, const Next& b) {
      return std::pair(a.key(), a.item().id) < std::pair(b.key(), b.item().id);
    });
    return all;
  }
  /// Takes a task out of the queue. It counts as running for its client until end().
  Item take(const Next& next) {
    Line& line = next.client->line(next.priority);
    line.resumed_was_last = line.resumed_is_next();
    std::deque<Item>& from = line.resumed_was_last ? line.resumed : line.queue;
    Item item = std::move(from.front());
    from.pop_front();
    ++next.client->running;
    return item;
  }
  void end(Client& client) { --client.running; }
  /// Removes the newest queued task of this client and class and returns it. There must be one.
  Item take_newest(const Next& next) {
    std::deque<Item>& from = next.client->line(next.priority).queue;
    Item item = std::move(from.back());
    from.pop_back();
    return item;
  }

  /// Removes a queued task and returns it. Returns nothing if it is not here, or if it is a resumed task.
  std::optional<Item> remove(std::uint64_t id) {
    for (const Priority priority : kPriorities)
      if (std::optional<Item> item = remove(id, priority, &Line::queue)) return item;
    return std::nullopt;
  }
  /// As above, but for a resumed task.
  std::optional<Item> remove_resumed(std::uint64_t id) {
    for (const Priority priority : kPriorities)
      if (std::optional<Item> item = remove(id, priority, &Line::resumed)) return item;
    return std::nullopt;
  }
  /// Moves a waiting task to this class. If the task is queued and not resumed, it takes the turn of this flow. Returns true
  /// in that case.
  bool move(std::uint64_t id, Priority to, const Flow& flow) {
    for (const Priority priority : kPriorities) {
      if (priority == to) continue;
      if (std::optional<Item> resumed = remove(id, priority, &Line::resumed)) {
        push_resumed(to, std::move(*resumed));
      } else if (std::optional<Item> queued = remove(id, priority, &Line::queue)) {
        queued->flow = flow;
        push(to, std::move(*queued));
        return true;
      }
    }
    return false;
  }
  /// Lets a queued task take the turn of this flow if that comes sooner; returns true in that case. `per_cost`: returns
  /// how many seconds a client needs for each second of cost.
  template <class PerCost>
  bool hasten(std::uint64_t id, const Flow& flow, const PerCost& per_cost) {
    for (auto& [name, client] : clients_) {
      if (name == flow.name) continue;
      for (const Priority priority : kPriorities) {
        std::deque<Item>& queue = client.line(priority).queue;
        const auto at =
            std::find_if(queue.begin(), queue.end(), [&](const Item& item) { return item.id == id; });
        if (at == queue.end()) continue;
        const double now = turn_of(client, priority, id, per_cost(client));
        Client& sooner = arrives(flow);
        if (turn_of(sooner, priority, id, per_cost(sooner)) >= now) return false;
        Item item = std::move(*at);
        queue.erase(at);
        item.flow = flow;
        push(priority, std::move(item));
        return true;
      }
    }
    return false;
  }
  /// Returns a waiting task; null if the task does not wait.
  Item* find(std::uint64_t id) {
    for (auto& [name, client] : clients_)
      for (Line& line : client.lines)
        for (std::deque<Item>* items : {&line.resumed, &line.queue})
          for (Item& item : *items)
            if (item.id == id) return &item;
    return nullptr;
  }

  // -- used time

  /// Charges this flow for the seconds used in this class.
  void charge(Priority priority, const Flow& flow, double seconds) {
    Client& client = arrives(flow);
    client.tag = std::max(client.tag, now_ - kCredit) + cost_of(priority) * seconds / client.weight;
    client.tag = std::min(client.tag, now_ + kMostDebt);
  }
  /// Tells the queue the lowest tag of all clients that are computing.
  void advance(double tag) { now_ = std::max(now_, tag); }

  // -- figures

  bool empty() const { return size() == 0; }
  std::size_t size() const {
    std::size_t size = 0;
    for (const Priority priority : kPriorities) size += this->size(priority) + resumed(priority);
    return size;
  }
  /// Returns the number of queued tasks in this class, without resumed ones.
  std::size_t size(Priority priority) const {
    return sum(priority, [](const Line& line) { return line.queue.size(); });
  }
  std::size_t resumed(Priority priority) const {
    return sum(priority, [](const Line& line) { return line.resumed.size(); });
  }
  std::size_t size_of(const std::string& flow, Priority priority) const {
    const auto at = clients_.find(flow);
    return at == clients_.end() ? 0 : at->second.line(priority).queue.size();
  }
  /// Returns how many other flows than this one have queued tasks.
  std::size_t others_than(const std::string& flow, Priority priority) const {
    return sum(priority, [](const Line& line) { return static_cast<std::size_t>(!line.queue.empty()); }) -
           (size_of(flow, priority) > 0 ? 1 : 0);
  }

  /// Returns the ids of all queued tasks in the order in which they would begin. Assumes that nothing else arrives, that one
  /// processor does all the work, and that the costs are right.
  std::vector<std::uint64_t> order() const {
    struct Place {
      bool operator>(const Place& other) const { return std::pair(key, id) > std::pair(other.key, other.id); }
      double key;
      std::uint64_t id;
      const Client* client;
      std::size_t line, k;
      double tag;
    };
    std::priority_queue<Place, std::vector<Place>, std::greater<>> turns;
    const auto add = [&turns](const Client& client, std::size_t line, std::size_t k, double tag) {
      for (; line < client.lines.size(); ++line, k = 0)
        if (const auto& queue = client.lines[line].queue; k < queue.size())
          return turns.push({key(tag, static_cast<Priority>(line)), queue[k].id, &client, line, k, tag});
    };
    for (const auto& [name, client] : clients_) add(client, 0, 0, client.tag);
    std::vector<std::uint64_t> served;
    while (!turns.empty()) {
      const Place turn = turns.top();
      turns.pop();
      served.push_back(turn.id);
      const double cost =
          turn.client->lines[turn.line].queue[turn.k].cost * cost_of(static_cast<Priority>(turn.line));
      add(*turn.client, turn.line, turn.k + 1, turn.tag + cost / turn.client->weight);
    }
    return served;
  }

  /// Returns how many seconds of other work would be computed before a new task of this flow and class ends. `seconds`: time
  /// that the new task takes. `left`: returns the seconds that the waiting and running tasks of a client and class should
  /// still take.
  template <class Left>
  double ahead_of(Priority priority, const Flow& flow, double seconds, const Left& left) const {
    Client mine;
    mine.tag = now_ - kCredit;
    double ahead = 0, own = cost_of(priority) * seconds / flow.weight;
    const auto at = clients_.find(flow.name);
    if (at != clients_.end()) {
      mine.tag = at->second.rests() ? std::max(at->second.tag, mine.tag) : at->second.tag;
      for (const Priority of : kPriorities) {
        if (of > priority) break;
        ahead += left(at->second, of);
        own += cost_of(of) * left(at->second, of) / flow.weight;
      }
    }
    const double ends = mine.key(priority) + own;
    for (const auto& [name, client] : clients_) {
      if (name == flow.name) continue;
      double used = 0;
      for (const Priority of : kPriorities) {
        const double until = std::max(0.0, ends - client.key(of) - used) * client.weight / cost_of(of);
        const double computed = std::min(left(client, of), until);
        ahead += computed;
        used += cost_of(of) * computed / client.weight;
      }
    }
    return ahead;
  }

  /// Returns the seconds of all remaining work in this class and in more urgent ones.
  template <class Left>
  double left(Priority priority, const Left& left_of) const {
    double seconds = 0;
    for (const auto& [name, client] : clients_)
      for (const Priority of : kPriorities)
        if (of <= priority) seconds += left_of(client, of);
    return seconds;
  }

  // -- remembered clients

  /// Forgets all clients. Call it at the end of a busy period, when nothing is queued and nothing runs.
  void idle() {
    clients_.clear();
    now_ = 0;
  }
  /// Forgets clients that rest and owe nothing, so that one-time clients leave nothing behind. If more than `most` clients
  /// remain, forgets all clients that rest, including their debts.
  void sweep(std::size_t most) {
    std::erase_if(clients_, [this](const auto& entry) {
      return entry.second.rests() && entry.second.tag <= now_ - kCredit;
    });
    if (clients_.size() > most)
      std::erase_if(clients_, [](const auto& entry) { return entry.second.rests(); });
  }
  std::size_t flows() const { return clients_.size(); }

 private:
  static constexpr double key(double tag, Priority priority) {
    return tag - kLead * (1 - static_cast<double>(priority));
  }
  /// Returns the tag that this client will have after all tasks that it serves before a queued task of this class and id.
  static double turn_of(const Client& client, Priority priority, std::uint64_t id, double per_cost) {
    double tag = client.tag;
    for (const Priority of : kPriorities)
      for (const auto* items : {&client.line(of).resumed, &client.line(of).queue})
        for (const Item& item : *items)
          if (of < priority || (of == priority && (items == &client.line(of).resumed || item.id < id)))
            tag += cost_of(of) * per_cost * item.cost / client.weight;
    return tag;
  }
  /// Returns the client of this flow. If the client is new or has no tasks, its credit is limited to kCredit.
  Client& arrives(const Flow& flow) {
    const auto [at, is_new] = clients_.try_emplace(flow.name);
    Client& client = at->second;
    if (is_new) client.name = flow.name;
    if (is_new || client.rests()) client.tag = is_new ? now_ - kCredit : std::max(client.tag, now_ - kCredit);
    client.weight = flow.weight;
    return client;
  }
  static void insert(std::deque<Item>& items, Item item) {
    const auto behind =
        std::find_if(items.begin(), items.end(), [&](const Item& other) { return other.id > item.id; });
    items.insert(behind, std::move(item));
  }
  std::optional<Item> remove(std::uint64_t id, Priority priority, std::deque<Item> Line::*items) {
    for (auto& [name, client] : clients_) {
      std::deque<Item>& from = client.line(priority).*items;
      const auto at = std::find_if(from.begin(), from.end(), [&](const Item& item) { return item.id == id; });
      if (at == from.end()) continue;
      Item item = std::move(*at);
      from.erase(at);
      return item;
    }
    return std::nullopt;
  }
  template <class Count>
  std::size_t sum(Priority priority, const Count& count) const {
    std::size_t sum = 0;
    for (const auto& [name, client] : clients_) sum += count(client.line(priority));
    return sum;
  }

  std::map<std::string, Client> clients_;
  double now_ = 0;
};

}  // namespace fracture
