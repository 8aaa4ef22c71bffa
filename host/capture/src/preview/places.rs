//! Places for connections. When all are taken a new client gets that of the one that matters least,
//! so that slow or hostile clients lock nobody out.

use std::collections::BTreeMap;
use std::net::IpAddr;
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::Instant;

use tokio::task::AbortHandle;

/// Connections at once. A browser takes up to six.
const MAX_CONNECTIONS: usize = 100;

/// The connections that there are, by numbers that count up.
#[derive(Debug, Default)]
pub(super) struct Places(Mutex<Taken>);

#[derive(Debug, Default)]
struct Taken {
    next: u64,
    connections: BTreeMap<u64, Connection>,
}

#[derive(Debug)]
struct Connection {
    peer: IpAddr,
    /// When it last asked for something; `None` if it never did.
    asked: Option<Instant>,
    task: Option<AbortHandle>,
}

/// One connection's place, free again when dropped.
#[derive(Debug)]
pub(super) struct Place {
    places: Arc<Places>,
    key: u64,
}

impl Places {
    /// A place for a client, if need be that of another one, whose connection ends.
    pub fn take(places: &Arc<Self>, peer: IpAddr) -> Place {
        let mut taken = places.lock();
        if taken.connections.len() >= MAX_CONNECTIONS
            && let Some(key) = taken.least_important()
            && let Some(connection) = taken.connections.remove(&key)
            && let Some(task) = connection.task
        {
            task.abort();
        }
        let key = taken.next;
        taken.next += 1;
        let connection = Connection {
            peer,
            asked: None,
            task: None,
        };
        taken.connections.insert(key, connection);
        drop(taken);
        Place {
            places: places.clone(),
            key,
        }
    }

    /// What to abort when the place goes to somebody else.
    pub fn set_task(&self, key: u64, task: AbortHandle) {
        if let Some(connection) = self.lock().connections.get_mut(&key) {
            connection.task = Some(task);
        }
    }

    fn lock(&self) -> MutexGuard<'_, Taken> {
        super::lock(&self.0)
    }
}

impl Taken {
    /// Of the address with most connections, one that never asked for anything, or else the one
    /// that has not asked for longest; the oldest of equals.
    fn least_important(&self) -> Option<u64> {
        let mut counts = BTreeMap::new();
        for connection in self.connections.values() {
            *counts.entry(connection.peer).or_insert(0_usize) += 1;
        }
        let order = |(key, connection): &(&u64, &Connection)| {
            let fewer = usize::MAX - counts.get(&connection.peer).unwrap_or(&0);
            (fewer, connection.asked, **key)
        };
        self.connections
            .iter()
            .min_by_key(order)
            .map(|(key, _)| *key)
    }
}

impl Place {
    /// Number of the connection.
    pub fn key(&self) -> u64 {
        self.key
    }

    /// The client has asked for something.
    pub fn asked(&self) {
        if let Some(connection) = self.places.lock().connections.get_mut(&self.key) {
            connection.asked = Some(Instant::now());
        }
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        self.places.lock().connections.remove(&self.key);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn has(places: &Places, place: &Place) -> bool {
        places.lock().connections.contains_key(&place.key)
    }

    #[test]
    fn a_full_house_gives_up_who_never_asked_then_who_asked_longest_ago() {
        let places = Arc::new(Places::default());
        let peer: IpAddr = [10, 0, 0, 1].into();
        let all: Vec<_> = (0..MAX_CONNECTIONS)
            .map(|_| Places::take(&places, peer))
            .collect();
        for (i, place) in all.iter().enumerate() {
            if i != 7 {
                place.asked();
            }
        }
        let first = Places::take(&places, peer);
        first.asked();
        assert!(!has(&places, &all[7]) && has(&places, &all[0]) && has(&places, &first));
        let second = Places::take(&places, peer);
        assert!(!has(&places, &all[0]) && has(&places, &all[1]) && has(&places, &second));
        drop((first, second));
        assert_eq!(places.lock().connections.len(), MAX_CONNECTIONS - 2);
    }

    #[test]
    fn who_takes_most_places_loses_one_to_others() {
        let places = Arc::new(Places::default());
        let [phone, flood]: [IpAddr; 2] = [[10, 0, 0, 1].into(), [10, 0, 0, 2].into()];
        let quiet = Places::take(&places, phone);
        let all: Vec<_> = (0..3 * MAX_CONNECTIONS)
            .map(|_| {
                let place = Places::take(&places, flood);
                place.asked();
                place
            })
            .collect();
        assert!(has(&places, &quiet), "a flood does not drive out the phone");
        assert!(!has(&places, &all[0]));
        assert_eq!(places.lock().connections.len(), MAX_CONNECTIONS);
    }
}
