//! Pause, seek and speed, by viewers and from within the program.

use inhand_live::{Control, Event, Mode, Settings};

use crate::client::{Client, SDK, Said, WEBSOCKET, is_ended, messages};
use crate::files::{self, MS, START, settings, start};

fn paused() -> Settings {
    Settings {
        paused: true,
        ..settings()
    }
}

/// A client that has seen the first instant of a paused recording.
fn at_start(server: &files::Running, protocol: &str) -> Client {
    let mut client = Client::connect(server.address, protocol);
    client.subscribe_all();
    let mut left = 3;
    while left > 0 {
        if let Said::Message(_, time, _) = client.next() {
            assert_eq!(time, START);
            left -= 1;
        }
    }
    client
}

#[test]
fn nothing_comes_while_it_is_paused() {
    let server = start(&paused());
    let mut client = at_start(&server, SDK);
    // Every answer comes after whatever was sent before it.
    for n in 0..20 {
        let id = format!("{n}");
        client.playback(false, 1.0, None, &id);
        let (between, state) = client.answer(&id);
        assert_eq!(between, []);
        assert_eq!((state.status, state.time, state.speed), (1, START, 1.0));
        assert!(!state.did_seek);
    }
    server.stop();
}

#[test]
fn a_pause_holds_the_time_that_it_tells() {
    let server = start(&Settings {
        speed: 1.0,
        ..settings()
    });
    let mut client = Client::connect(server.address, SDK);
    client.subscribe(&["/a"]);
    client.until(|said| matches!(said, Said::Message(..)));
    client.playback(false, 1.0, None, "stop");
    let (_, first) = client.answer("stop");
    assert_eq!(first.status, 1);
    // What was due at that time, and not a message more.
    client.playback(false, 1.0, None, "again");
    let (between, second) = client.answer("again");
    assert_eq!(second.time, first.time);
    assert!(
        messages(&between)
            .iter()
            .all(|(_, time, _)| *time <= first.time)
    );
    client.playback(false, 1.0, None, "third");
    assert_eq!(client.answer("third").0, []);
    server.stop();
}

#[test]
fn a_seek_sends_what_holds_there_and_nothing_else() {
    let server = start(&paused());
    let mut client = at_start(&server, SDK);
    // Forth, back, to the same place, beyond both ends.
    let stops = [(603, 603), (52, 52), (52, 52), (99_999, 1190), (0, 0)];
    for (n, (to, reached)) in stops.into_iter().enumerate() {
        let (id, after) = (format!("seek {n}"), format!("after {n}"));
        client.playback(false, 1.0, Some(START + to * MS), &id);
        let (before, state) = client.answer(&id);
        assert_eq!(messages(&before), []);
        assert_eq!((state.time, state.did_seek), (START + reached * MS, true));
        assert_eq!(client.next(), Said::Time(START + reached * MS));
        // The turn after the seek brings what lies at that very instant.
        let mut latest = std::collections::BTreeMap::new();
        for (topic, time, data) in files::messages() {
            if time <= START + reached * MS {
                latest.insert(topic, (time, data));
            }
        }
        let mut last = std::collections::BTreeMap::new();
        while last != latest {
            if let Said::Message(topic, time, data) = client.next() {
                assert!(time <= START + reached * MS);
                last.insert(topic, (time, data));
            }
        }
        client.playback(false, 1.0, None, &after);
        assert_eq!(messages(&client.answer(&after).0), []);
    }
    server.stop();
}

#[test]
fn after_a_seek_it_plays_on_from_there() {
    let server = start(&paused());
    let mut client = at_start(&server, SDK);
    client.playback(true, 50.0, Some(START + 900 * MS), "go");
    let (_, state) = client.answer("go");
    assert_eq!((state.status, state.speed), (0, 50.0));
    let found = messages(&client.until(is_ended));
    let rest: Vec<_> = (files::messages().into_iter())
        .filter(|(_, time, _)| *time >= START + 900 * MS)
        .collect();
    // In front of it, of each topic, the message that held.
    assert_eq!(found.len(), rest.len() + 3);
    assert_eq!(found[3..], rest);
    // Play at the end plays anew.
    client.playback(true, 50.0, None, "anew");
    let (_, state) = client.answer("anew");
    assert_eq!((state.status, state.time, state.did_seek), (0, START, true));
    assert_eq!(messages(&client.until(is_ended)), files::messages());
    server.stop();
}

#[test]
fn lichtblick_sees_a_seek_as_time_that_goes_back() {
    let server = start(&settings());
    let mut client = Client::connect(server.address, WEBSOCKET);
    client.subscribe_all();
    client.until(|said| matches!(said, Said::Message(topic, ..) if topic == "/b"));
    server.wait_for(|event| *event == Event::Ended);
    assert!(server.controls.send(Control::SeekTo(0.0)));
    let back = |said: &Said| *said == Said::Time(START);
    client.until(|said| *said == Said::Time(START + 1190 * MS));
    let late = client.until(back);
    // All of it was sent before the seek: nothing of the end comes after the time that went back.
    assert!(
        messages(&late)
            .iter()
            .all(|(_, time, _)| *time == START + 1190 * MS)
    );
    let again = client.until(|said| *said == Said::Time(START + 1190 * MS));
    let all = files::messages();
    assert_eq!(messages(&again)[..], all[..all.len() - 1]);
    server.stop();
}

#[test]
fn a_viewer_without_playback_states_gets_them_once_it_asks() {
    let server = start(&paused());
    let mut client = at_start(&server, WEBSOCKET);
    client.playback(false, 3.0, None, "asks");
    assert_eq!(client.answer("asks").1.speed, 3.0);
    server.stop();
}

#[test]
fn the_program_controls_it_too() {
    let server = start(&paused());
    let mut client = at_start(&server, SDK);
    let state = |client: &mut Client| loop {
        if let Said::State(state) = client.next() {
            assert_eq!(state.request, "");
            return state;
        }
    };
    let send = |control| assert!(server.controls.send(control));
    send(Control::Slower);
    assert_eq!(state(&mut client).speed, 16.0);
    send(Control::Faster);
    assert_eq!(state(&mut client).speed, 32.0);
    send(Control::SeekTo(0.5));
    assert_eq!(state(&mut client).time, START + 500 * MS);
    send(Control::SeekBy(0.25));
    assert_eq!(state(&mut client).time, START + 750 * MS);
    send(Control::SeekBy(-9.0));
    assert_eq!(state(&mut client).time, START);
    send(Control::Toggle);
    assert_eq!(state(&mut client).status, 0);
    let end = client.until(is_ended);
    assert!(!messages(&end).is_empty());
    send(Control::Toggle);
    let anew = state(&mut client);
    assert_eq!((anew.status, anew.time, anew.did_seek), (0, START, true));
    server.stop();
}

#[test]
fn a_speed_that_cannot_be_is_brought_within_limits_or_ignored() {
    let server = start(&paused());
    let mut client = at_start(&server, SDK);
    for (n, (asked, got)) in [
        (1e9, 100.0),
        (1e-9, 0.01),
        (1e9, 100.0),
        (f32::INFINITY, 100.0),
        (f32::NAN, 100.0),
        (-1.0, 100.0),
        (0.0, 100.0),
    ]
    .into_iter()
    .enumerate()
    {
        let id = format!("speed {n}");
        client.playback(false, asked, None, &id);
        assert_eq!(client.answer(&id).1.speed, got, "{asked}");
    }
    server.stop();
}

#[test]
fn time_stands_until_someone_watches_and_while_nobody_does() {
    let server = start(&Settings {
        speed: 0.01,
        ..settings()
    });
    let mode = |wanted: Mode| {
        server.wait_for(|event| matches!(event, Event::Progress(now) if now.mode == wanted))
    };
    mode(Mode::Waiting);
    let mut client = Client::connect(server.address, SDK);
    client.subscribe(&["/a"]);
    mode(Mode::Playing);
    client.send(&serde_json::json!({"op": "unsubscribe", "subscriptionIds": [100]}));
    mode(Mode::Waiting);
    server.stop();
}

#[test]
fn unattended_it_plays_to_the_end_for_nobody() {
    let server = start(&Settings {
        unattended: true,
        repeat: inhand_live::Repeat::Finish,
        ..settings()
    });
    let played = server.end().unwrap();
    assert_eq!((played.viewers, played.sent), (0, 0));
}
