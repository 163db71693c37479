//! Plain tables: columns as wide as their widest entry.

/// Rows under a head, each line indented by two spaces; the columns of `right` are aligned right.
pub fn table(head: &[&str], rows: &[Vec<String>], right: &[usize]) -> String {
    let width = |(column, title): (usize, &&str)| {
        let entries = rows.iter().filter_map(|row| row.get(column));
        let widest = entries.map(|entry| entry.chars().count()).max();
        widest.unwrap_or(0).max(title.chars().count())
    };
    let widths: Vec<usize> = head.iter().enumerate().map(width).collect();
    let line = |row: &[String]| {
        let cells = row.iter().zip(&widths).enumerate().map(|(i, (entry, &w))| {
            if right.contains(&i) {
                format!("{entry:>w$}")
            } else {
                format!("{entry:<w$}")
            }
        });
        format!("  {}", cells.collect::<Vec<_>>().join("  "))
            .trim_end()
            .to_owned()
    };
    let head: Vec<String> = head.iter().map(|title| (*title).to_owned()).collect();
    let lines = std::iter::once(line(&head)).chain(rows.iter().map(|row| line(row)));
    lines.collect::<Vec<_>>().join("\n") + "\n"
}

#[cfg(test)]
mod tests {
    use crate::text_table::table;

    #[test]
    fn columns_line_up() {
        let rows = [
            vec![String::from("a"), String::from("1.5")],
            vec![String::from("µm lens"), String::from("-10.25")],
        ];
        assert_eq!(
            table(&["name", "z"], &rows, &[1]),
            "  name          z\n  a           1.5\n  µm lens  -10.25\n"
        );
    }
}
