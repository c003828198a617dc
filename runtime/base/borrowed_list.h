// A list that a function borrows from its thread: it keeps its room, so that queries allocate nothing once warm, and
// queries within queries each have one of their own.
#pragma once
#include <deque>
#include <vector>

namespace feder {

template <class T>
class BorrowedList {
 public:
  BorrowedList() : list_(take()) {}
  ~BorrowedList() { --depth(); }
  BorrowedList(const BorrowedList&) = delete;
  BorrowedList& operator=(const BorrowedList&) = delete;
  std::vector<T>& operator*() { return list_; }
  std::vector<T>* operator->() { return &list_; }

 private:
  static std::size_t& depth() {
    thread_local std::size_t n = 0;
    return n;
  }
  static std::vector<T>& take() {
    thread_local std::deque<std::vector<T>> pool;  // grows without moving what is lent
    if (pool.size() <= depth()) pool.emplace_back();
    std::vector<T>& list = pool[depth()++];
    list.clear();
    return list;
  }
  std::vector<T>& list_;
};

}  // namespace feder
